import zipfile

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput

TIMES = np.array([0.0, 0.1, 0.3])
QUATERNIONS = np.tile([0.0, 1.0, 0.0, 0.0], (3, 1))


@pytest.fixture
def save(tmp_path):
    def to_file(**arrays):
        np.savez(tmp_path / "recording.npz", **arrays)
        return tmp_path / "recording.npz"

    return to_file


def test_arrays_make_points_poses_or_joints(save):
    positions = np.arange(9.0).reshape(3, 3)
    points = lt.read_motion(save(times=TIMES, positions=positions))
    assert np.array_equal(points.times, TIMES)
    assert np.array_equal(points.positions, positions)
    poses = lt.read_motion(save(times=TIMES, positions=positions, orientations_wxyz=QUATERNIONS))
    assert np.array_equal(poses.orientations, QUATERNIONS)
    joints = lt.read_motion(save(times=TIMES, joints=np.zeros((3, 7), np.float32)))
    assert joints.positions.shape == (3, 7)


def test_other_names_can_be_mapped(save):
    path = save(stamps=TIMES, a=np.ones(3), b=np.zeros((3, 2)), note=np.array("hand guided"))
    motion = lt.read_motion(path, columns={"time": "stamps", "positions": ["a", "b"]})
    assert np.array_equal(motion.positions, [[1, 0, 0]] * 3)


def test_arrays_that_make_no_motion_are_refused_and_objects_never_loaded(save):
    for arrays, message in [
        ({"times": TIMES}, "no names of positions or joints found"),
        ({"positions": np.zeros((3, 2))}, "rate: the file has no time column"),
        ({"times": TIMES, "positions": np.zeros((2, 2))}, "times: expected one time for each of 2"),
        ({"times": TIMES, "positions": np.full((3, 2), np.inf)}, "'positions': expected a finite"),
        ({"times": TIMES, "positions": np.zeros((3, 2, 2))}, "positions: expected shape"),
        ({"times": TIMES, "positions": np.array(["a", "b", "c"])}, "positions: expected numbers"),
        ({"times": TIMES, "positions": np.zeros((3, 2), complex)}, "positions: expected numbers"),
        ({"times": TIMES, "positions": np.zeros((0, 2))}, "times: expected one time for"),
        ({"times": TIMES[:0], "positions": np.zeros((0, 2))}, "at least one sample"),
        ({"times": TIMES, "joints": TIMES, "positions": np.zeros((3, 2))}, "both poses and joints"),
    ]:
        refused(message, lt.read_motion, save(**arrays))
    with pytest.raises(InvalidInput, match=r"not a readable .npz archive of plain arrays"):
        lt.read_motion(save(times=TIMES, positions=np.array([object()] * 3)))


def test_what_is_no_archive_is_refused(tmp_path):
    path = tmp_path / "recording.npz"
    np.save(tmp_path / "array.npy", TIMES)
    with zipfile.ZipFile(tmp_path / "text.npz", "w") as archive:
        archive.writestr("times.npy", "not an array")
    for content in (b"", b"text", (tmp_path / "array.npy").read_bytes()):
        path.write_bytes(content)
        refused(r"not a readable .npz archive", lt.read_motion, path)
    with pytest.raises(InvalidInput):
        lt.read_motion(tmp_path / "text.npz")
