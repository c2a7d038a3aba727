import json

import h5py
import numpy as np
import pytest
from motions import two_pandas
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput

JOINTS = {"joints": ["robot0_joint_pos"]}
POSES = {"positions": ["robot0_eef_pos"], "orientations": ["robot0_eef_quat"]}
TURNED = lt.rotations.exp(np.linspace([0, 0, 0], [0.3, -0.4, 0.5], 6))


@pytest.fixture
def dataset(tmp_path):
    """Ten demonstrations as robomimic writes them, the i-th with joints at i."""
    path = tmp_path / "low_dim.hdf5"
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["env_args"] = json.dumps({"env_kwargs": {"control_freq": 20}})
        for i in range(10):
            obs = data.create_group(f"demo_{i}/obs")
            obs["robot0_joint_pos"] = np.full((6, 7), i, np.float32)
            obs["robot0_eef_pos"] = np.ones((6, 3))
            obs["robot0_eef_quat"] = TURNED[:, [1, 2, 3, 0]]
            obs["agentview_image"] = np.zeros((6, 84, 84, 3), np.uint8)
            data[f"demo_{i}/actions"] = np.zeros((6, 7))
    return path


def test_demonstrations_come_in_the_order_of_their_numbers(dataset):
    demonstrations = lt.read_demonstrations(dataset, columns=JOINTS)
    assert [d.name for d in demonstrations] == [f"demo_{i}" for i in range(10)]
    assert [d.motion.positions[0, 0] for d in demonstrations] == list(range(10))
    np.testing.assert_allclose(demonstrations[0].motion.times, np.arange(6) / 20)


def test_quaternions_are_turned_from_x_y_z_w(dataset):
    motion = lt.read_demonstrations(dataset, columns=POSES)[0].motion
    np.testing.assert_allclose(motion.orientations, TURNED, atol=1e-12)


def test_joints_or_poses_have_to_be_chosen(dataset):
    refused(r"positions \(robot0_eef_pos\) or joints \(robot0_joi", lt.read_demonstrations, dataset)


def test_the_rate_is_asked_for_where_the_file_does_not_say(dataset):
    assert lt.read_demonstrations(dataset, columns=JOINTS, rate=10)[0].motion.duration == 0.5
    for attribute in ("no json", json.dumps({"env_kwargs": {"control_freq": -1}}), 3):
        with h5py.File(dataset, "a") as file:
            file["data"].attrs["env_args"] = attribute
        with pytest.raises(InvalidInput, match="rate: the file has no time column"):
            lt.read_demonstrations(dataset, columns=JOINTS)


def test_another_layout_is_refused(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["positions"] = np.zeros((3, 3))
    refused("expected groups data/demo_<i>", lt.read_demonstrations, tmp_path / "other.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    refused("not a readable robomimic HDF5 file", lt.read_demonstrations, tmp_path / "text.h5")


def test_a_claim_of_ten_gigabytes_is_refused_before_it_takes_memory(tmp_path):
    with h5py.File(tmp_path / "huge.h5", "w") as file:
        file.create_dataset(
            "data/demo_0/obs/robot0_joint_pos", (200_000_000, 7), "f4", chunks=(1000, 7)
        )
    refused("it claims 1,400,000,000", lt.read_demonstrations, tmp_path / "huge.h5", rate=20)


def test_the_joints_of_two_arms_are_named_by_the_user_the_left_ones_first(dataset):
    """A data set does not say which arm is the left one: none is chosen or left out unasked."""
    with h5py.File(dataset, "a") as file:
        for name, own in file["data"].items():
            own["obs/robot1_joint_pos"] = np.full((6, 7), -int(name[5:]), np.float32)
    refused(
        "name the columns to read, there are .*robot1_joint_pos", lt.read_demonstrations, dataset
    )
    columns = {"joints": ["robot1_joint_pos", "robot0_joint_pos"]}
    demonstrations = lt.read_demonstrations(dataset, columns=columns)
    left, right = two_pandas().motions(demonstrations[1].motion)
    np.testing.assert_array_equal(left.positions, np.full((6, 7), -1.0))
    np.testing.assert_array_equal(right.positions, np.full((6, 7), 1.0))
