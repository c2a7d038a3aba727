"""Demonstrations as they were recorded, written as a data set and read back."""

import json
import math

import h5py
import numpy as np
import pytest
from motions import minimum_jerk
from pyarrow import parquet
from refusals import refused

import leadthrough as lt
from leadthrough.augmentation import write_data_set

HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])  # rad
POST = lt.Box((0.1, 0.1, 0.4), (0.5, 0.35, 0.2))


@pytest.fixture(scope="module")
def recorded(panda):
    found = []
    for k in range(3):
        times = np.cumsum(np.random.default_rng(k).uniform(0.015, 0.03, 120))
        times -= times[0]
        phase = (times / times[-1])[:, None]
        rows = HOME + minimum_jerk(phase) * [0.6, 0.4, 0.1 * k, 0.3, 0.0, 0.1, 0.2]
        closing = lt.Event(float(times[60]), "close gripper")
        motion = lt.JointTrajectory(times, rows, joint_names=panda.joint_names, events=[closing])
        found.append(lt.Demonstration(motion, f"take {k}"))
    return found


def test_a_lerobot_data_set_has_the_motions_at_its_frames(recorded, panda, tmp_path):
    folder = write_data_set(recorded, panda, tmp_path / "set", [POST], rate=50.0)
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert (info["codebase_version"], info["total_episodes"], info["fps"]) == ("v3.0", 3, 50)
    assert info["features"]["observation.state"]["names"] == [*panda.joint_names, "gripper"]
    back = lt.read_demonstrations(folder, rest=math.inf)
    assert len(back) == 3
    for ours, given in zip(back, recorded, strict=True):
        motion, shown = ours.motion, given.motion
        assert motion.duration == pytest.approx(shown.duration, abs=1 / 50)
        at = motion.times / motion.duration * shown.duration
        np.testing.assert_allclose(motion.positions[:, :7], shown.at(at), atol=1e-3)
    table = parquet.read_table(folder / "data" / "chunk-000" / "file-000.parquet")
    rows = {name: np.array(table[name].to_pylist()) for name in table.column_names}
    first = rows["episode_index"] == 0
    state = rows["observation.state"][first]
    np.testing.assert_allclose(rows["action"][first][:-1], state[1:], atol=1e-6)
    tips, _ = panda.forward_kinematics(state[:, :7].astype(float))
    np.testing.assert_allclose(rows["observation.ee_pose"][first][:, :3], tips, atol=1e-5)
    closed = rows["timestamp"][first] >= recorded[0].motion.events[0].time + 0.03
    assert state[0, 7] == 1.0
    assert (state[closed, 7] == 0.0).all()
    around = rows["observation.environment_state"][first]
    np.testing.assert_allclose(around[0, :3], tips[-1], atol=1e-4)
    np.testing.assert_allclose(around[0, 7:], POST.position, atol=1e-6)


def test_the_same_as_robomimic_reads_it_and_without_a_gripper(recorded, panda, tmp_path):
    still = [lt.Demonstration(each.motion[:40], each.name) for each in recorded]
    assert write_data_set([still[0].motion], panda, tmp_path / "one.hdf5").exists()
    path = write_data_set(still, panda, tmp_path / "set.hdf5", rate=20.0)
    with h5py.File(path) as file:
        assert file["data"].attrs["total"] == sum(
            len(file[f"data/demo_{i}/actions"]) for i in range(3)
        )
        assert file["data/demo_2"].attrs["demonstration"] == "take 2"
        assert file["data/demo_0/actions"].shape[1] == 7
        assert file["data/demo_0/obs/object"].shape[1] == 7


def test_nothing_a_wrong_rate_and_a_folder_that_is_there_are_refused(recorded, panda, tmp_path):
    for wrong in ([], None, recorded[0]):
        refused("demonstrations", write_data_set, wrong, panda, tmp_path / "set")
    one = recorded[0].motion[:1]
    refused("demonstration: expected at least two", write_data_set, [one], panda, tmp_path / "set")
    for rate in (0.0, np.nan, 1e12):
        refused("rate", write_data_set, recorded, panda, tmp_path / "set", rate=rate)
    refused("arm", write_data_set, recorded, None, tmp_path / "set")
    refused("task", write_data_set, recorded, panda, tmp_path / "set", task=None)
    refused("path", write_data_set, recorded, panda, None)
    (tmp_path / "there").write_text("")
    refused("path", write_data_set, recorded, panda, tmp_path)
