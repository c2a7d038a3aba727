"""Data sets of a skill's motions: read back, inside limits, clear, and the same bytes again."""

import json

import h5py
import numpy as np
import pytest
from cli.command_line import facts
from guard.judge import EXCESS, worst_use
from motions import minimum_jerk
from pyarrow import parquet
from refusals import refused

import leadthrough as lt
from leadthrough.augmentation import data_set
from leadthrough.shapes import RandomObstacle
from leadthrough.tasks import Execution
from leadthrough.validation import TargetRegion

RATE, COUNT = 30.0, 4
BALL = lt.Sphere(0.05, (0.55, -0.2, 0.5))
SCENE = [RandomObstacle(BALL, (0.05, 0.1, 0.1))]
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])  # rad


@pytest.fixture(scope="module")
def skill(panda):
    phase = np.linspace(0.0, 1.0, 51)[:, None]
    rows = HOME + minimum_jerk(phase) * [0.6, 0.4, 0.0, 0.3, 0.0, 0.1, 0.2]
    events = (lt.Event(1.5, "close gripper"), lt.Event(2.7, "gripper opened"))
    shown = lt.JointTrajectory(
        3.0 * phase[:, 0], rows, joint_names=panda.joint_names, events=events
    )
    return lt.DMP(weights=20).fit([panda.poses(shown)])


@pytest.fixture(scope="module")
def goals(skill):
    return TargetRegion.around(skill.generate().positions[-1], (0.15, 0.15, 0.1), turn=0.2)


@pytest.fixture(scope="module", autouse=True)
def few_motions_a_task():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(data_set, "_TOGETHER", 3)
        yield


@pytest.fixture(scope="module")
def folder(skill, panda, goals, tmp_path_factory):
    out = tmp_path_factory.mktemp("lerobot") / "episodes"
    found = lt.augment(skill, panda, SCENE, episodes=COUNT, out=out, goals=goals, seed=1)
    assert (found.path, found.episodes) == (out, COUNT)
    assert found.attempts == COUNT + sum(found.causes.values())
    assert f"{COUNT} episodes of {found.attempts} motions" in str(found)
    return out


def frames(folder):
    return parquet.read_table(folder / "data" / "chunk-000" / "file-000.parquet")


def columns(table, name):
    return np.array(table[name].to_pylist(), np.float64)


def test_episodes_are_read_back_with_names_and_events(folder, panda):
    episodes = lt.read_demonstrations(folder)
    assert len(episodes) == COUNT
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert info["features"]["action"]["names"] == [*panda.joint_names, "gripper"]
    assert info["codebase_version"] == "v3.0"
    total = len(frames(folder))
    assert (info["total_episodes"], info["total_frames"], info["fps"]) == (COUNT, total, 30)


def test_each_episode_keeps_all_limits_and_is_clear(folder, panda):
    table = frames(folder)
    number = columns(table, "episode_index")
    rows = columns(table, "observation.state")[:, :7]
    objects = columns(table, "observation.environment_state")
    assert np.ptp(objects[:, :3], axis=0).min() > 0.05
    for episode in range(COUNT):
        own = rows[number == episode]
        assert worst_use(own, panda.limits, RATE) <= 1.0 + EXCESS
        ball = BALL.at(objects[number == episode][0, -3:])
        assert panda.check(own, lt.Scene([ball], 0.0)).ok
        tip = panda.forward_kinematics(own[-1])[0]
        assert np.linalg.norm(tip - objects[number == episode][0, :3]) < 1e-3


def test_actions_are_the_next_rows(folder):
    table = frames(folder)
    same = np.diff(columns(table, "episode_index")) == 0
    for state, action in (("observation.state", "action"), ("observation.ee_pose", "ee_action")):
        rows = columns(table, state)
        assert np.array_equal(columns(table, action)[:-1][same], rows[1:][same])
    assert set(columns(table, "observation.state")[:, 7]) == {0.0, 1.0}


def test_the_gripper_follows_events_as_people_name_them(folder):
    table = frames(folder)
    own = columns(table, "episode_index") == 0
    gripper = columns(table, "observation.state")[own, 7]
    assert gripper[[0, len(gripper) // 2 + 5, -1]].tolist() == [1.0, 0.0, 1.0]


def test_statistics_and_indices_are_those_of_the_frames(folder):
    table = frames(folder)
    stats = json.loads((folder / "meta" / "stats.json").read_text())
    for name in ("observation.state", "action", "timestamp"):
        rows = columns(table, name).reshape(len(table), -1)
        for kind in ("min", "max", "mean", "std"):
            assert np.allclose(stats[name][kind], getattr(rows, kind)(axis=0), atol=1e-9)
    about = parquet.read_table(folder / "meta" / "episodes" / "chunk-000" / "file-000.parquet")
    ends = about["dataset_to_index"].to_pylist()
    assert ends == np.cumsum(about["length"].to_pylist()).tolist()
    assert ends[-1] == len(table)
    assert columns(table, "index").tolist() == list(range(len(table)))


def test_what_was_stopped_goes_on_to_the_same_bytes(folder, skill, panda, goals, tmp_path):
    def stopped(outcomes, total, label):
        yield next(iter(outcomes))
        raise KeyboardInterrupt

    asked = {"episodes": COUNT, "out": tmp_path / "episodes", "goals": goals, "seed": 1}
    kept = tmp_path / "motions"
    with pytest.raises(KeyboardInterrupt):
        lt.augment(skill, panda, SCENE, **asked, execution=Execution(out=kept, progress=stopped))
    assert not asked["out"].exists()
    lt.augment(skill, panda, SCENE, **asked, execution=Execution(out=kept))
    files = [path.relative_to(folder) for path in folder.rglob("*") if path.is_file()]
    assert len(files) == 6
    for file in files:
        assert (asked["out"] / file).read_bytes() == (folder / file).read_bytes()


def test_robomimic_has_the_same_motions(folder, skill, panda, goals, tmp_path):
    out = tmp_path / "episodes.hdf5"
    lt.augment(skill, panda, SCENE, episodes=COUNT, out=out, goals=goals, seed=1)
    table = frames(folder)
    number = columns(table, "episode_index")
    rows = columns(table, "observation.state")
    with h5py.File(out) as file:
        assert file["data"].attrs["total"] == len(rows)
        for episode in range(COUNT):
            demo = file[f"data/demo_{episode}"]
            own = rows[number == episode]
            assert demo.attrs["num_samples"] == len(own)
            assert np.array_equal(demo["obs/robot0_joint_pos"], own[:, :7])
            assert np.array_equal(demo["actions"][:-1], own[1:])
            x, y, z, w = demo["obs/robot0_eef_quat"][0]
            turn = panda.forward_kinematics(own[0, :7])[1]
            assert np.allclose([w, x, y, z], turn, atol=1e-9)
    joints = {"joints": ["robot0_joint_pos"]}
    assert len(lt.read_demonstrations(out, columns=joints)) == COUNT


def test_regions_out_of_reach_and_none_at_all_are_refused(skill, panda, tmp_path):
    with pytest.raises(lt.errors.NoPath, match=r"the arm can run 0 of 3 motions.*follow: limits"):
        lt.augment(
            skill,
            panda,
            episodes=3,
            out=tmp_path / "far",
            goals=TargetRegion.around([1.0, 0.3, 0.5], 0.02),
        )
    assert not (tmp_path / "far").exists()
    refused("goals: expected a region", lt.augment, skill, panda, episodes=3, out=tmp_path / "same")
    refused("episodes: ", lt.augment, skill, panda, episodes=0, out=tmp_path / "none")


def test_the_command_writes_a_data_set(skill, tmp_path):
    skill.save(tmp_path / "skill.npz")
    words = ["--robot", "panda", "--episodes", 2, "--goals", "0.05,0.05,0.05"]
    out = tmp_path / "episodes"
    told = facts("augment", tmp_path / "skill.npz", *words, "-o", out)
    assert told["episodes"] == 2
    assert (tmp_path / "episodes-motions" / "manifest.json").is_file()
    assert len(lt.read_demonstrations(out)) == 2
