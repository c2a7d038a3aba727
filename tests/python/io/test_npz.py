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
    for key in ("joints", "joint_positions"):
        path = save(times=TIMES, joint_names=np.array(["b", "a"]), **{key: np.zeros((3, 2))})
        assert lt.read_motion(path).joint_names == ("b", "a")


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


ROWS = np.column_stack([0.1 * np.arange(5), np.arange(30.0).reshape(5, 6) / 9.0])


def test_rows_of_an_npy_are_joints_at_a_rate_or_beside_the_column_of_times(tmp_path):
    path = tmp_path / "rows.npy"
    for rows, stated in ((ROWS[:, 1:], {"rate": 10.0}), (ROWS, {"columns": {"time": "1"}})):
        np.save(path, rows)
        motion = lt.read_motion(path, **stated)
        np.testing.assert_allclose(motion.times, ROWS[:, 0])
        np.testing.assert_array_equal(motion.positions, ROWS[:, 1:])
    refused("column 1 is time at 10 Hz", lt.read_motion, path, rate=10.0)
    some = lt.read_motion(path, columns={"time": "1", "positions": ["2", "4", "3"]})
    np.testing.assert_array_equal(some.positions, ROWS[:, [1, 3, 2]])


def test_three_numbers_a_row_are_a_position_and_three_joints_of_an_arm_that_has_as_many(tmp_path):
    np.save(tmp_path / "three.npy", ROWS[:, 1:4])
    assert type(lt.read_motion(tmp_path / "three.npy", rate=10.0)) is lt.Trajectory
    arm = dict.fromkeys("abc", (-9.0, 99.0))
    found = lt.read_motion(tmp_path / "three.npy", rate=10.0, joints=arm)
    assert type(found) is lt.JointTrajectory


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (ROWS, "no time column; give the rate in Hz, such as rate=100, or its column, as by "
               r"columns\['time'\]=1"),
        (ROWS.astype(str), "expected rows of numbers"),
        (ROWS[0], "expected rows of numbers"),
        (np.hstack([ROWS[:, :4], np.full((5, 4), 0.5)])[:, 1:], "of a pose; name the columns"),
    ],
)  # fmt: skip
def test_an_npy_that_is_not_clear_is_refused_with_the_words_that_make_it_so(tmp_path, rows, says):
    np.save(tmp_path / "rows.npy", rows)
    columns = None if len(rows) < 5 or rows is ROWS else {"time": "9"}
    refused(says, lt.read_motion, tmp_path / "rows.npy", columns=columns)


def test_a_pickled_npy_is_never_loaded(tmp_path):
    np.save(tmp_path / "rows.npy", np.array([{}], dtype=object), allow_pickle=True)
    refused("got pickled objects; save an array", lt.read_motion, tmp_path / "rows.npy", rate=10.0)


def test_seven_numbers_that_end_in_a_quaternion_are_neither_joints_nor_a_point(tmp_path):
    rows = np.hstack([ROWS[:, 1:4], np.full((5, 4), 0.5)])
    np.save(tmp_path / "rows.npy", rows)
    arm = dict.fromkeys("abcdefg", (-9.0, 99.0))
    refused("as of a pose; name", lt.read_motion, tmp_path / "rows.npy", rate=10.0, joints=arm)
    np.savez(tmp_path / "rows.npz", time=ROWS[:, 0], pos=rows)
    refused("as of a pose; save", lt.read_motion, tmp_path / "rows.npz")


def test_an_npy_of_a_row_for_each_joint_is_refused_as_transposed(tmp_path):
    np.save(tmp_path / "rows.npy", np.zeros((7, 300)))
    refused(r"got shape \(7, 300\); transpose", lt.read_motion, tmp_path / "rows.npy", rate=10.0)
