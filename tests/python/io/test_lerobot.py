import json

import numpy as np
import pyarrow as pa
import pytest
import so101
from motions import two_pandas
from pyarrow import parquet
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput

STATE = [[0.1 * i, -0.1 * i] for i in range(6)]


def save(path, state=STATE, **columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {
        "observation.state": pa.array(state, pa.list_(pa.float32())),
        "timestamp": pa.array([0.0, 0.1, 0.2, 0.0, 0.1, 0.2], pa.float32()),
        "episode_index": [3, 3, 3, 5, 5, 5],
        "task": ["pour"] * 6,
    }
    parquet.write_table(pa.table(content | columns), path)
    return path


def describe(folder, names):
    (folder / "meta").mkdir()
    info = {"fps": 10, "features": {"observation.state": {"names": names}}}
    (folder / "meta" / "info.json").write_text(json.dumps(info))


@pytest.fixture
def file(tmp_path):
    return save(tmp_path / "data" / "chunk-000" / "file-000.parquet")


def test_every_episode_is_a_demonstration(file):
    demonstrations = lt.read_demonstrations(file)
    assert [d.name for d in demonstrations] == ["episode_3", "episode_5"]
    for d, state in zip(demonstrations, (STATE[:3], STATE[3:]), strict=True):
        np.testing.assert_allclose(d.motion.positions, state, atol=1e-7)
        np.testing.assert_allclose(d.motion.times, [0, 0.1, 0.2], atol=1e-7)
        assert d.motion.joint_names == ()


@pytest.mark.parametrize("names", [["pan.pos", "lift.pos"], {"motors": ["pan.pos", "lift.pos"]}])
def test_a_data_set_names_its_joints(file, tmp_path, names):
    describe(tmp_path, names)
    for path in (tmp_path, file):
        motion = lt.read_demonstrations(path)[1].motion
        assert motion.joint_names == ("pan.pos", "lift.pos")
        np.testing.assert_allclose(motion.positions, STATE[3:], atol=1e-7)


def test_names_of_a_point_make_points(file, tmp_path):
    describe(tmp_path, ["x", "y"])
    assert type(lt.read_demonstrations(tmp_path)[0].motion) is lt.Trajectory


def test_joints_in_degrees_have_to_be_declared(tmp_path):
    path = save(tmp_path / "degrees.parquet", [[90.0 + i, -45.0] for i in range(6)])
    refused("angles='degrees' or angles='radians'", lt.read_demonstrations, path)
    motion = lt.read_demonstrations(path, angles="degrees")[0].motion
    np.testing.assert_allclose(motion.positions[0], [np.pi / 2, -np.pi / 4])


def test_other_tables_are_refused(tmp_path):
    parquet.write_table(pa.table({"x": [1.0]}), tmp_path / "other.parquet")
    with pytest.raises(InvalidInput, match=r"expected a column 'observation.state', got x"):
        lt.read_demonstrations(tmp_path / "other.parquet")
    with pytest.raises(InvalidInput, match="lists of one length"):
        lt.read_demonstrations(save(tmp_path / "ragged.parquet", [[1, 2], [1], [1, 2, 3]] * 2))
    (tmp_path / "text.parquet").write_text("no Parquet")
    refused("not a readable Parquet file", lt.read_demonstrations, tmp_path / "text.parquet")
    describe(tmp_path, None)
    refused(r"expected files data/\*\*/\*.parquet", lt.read_demonstrations, tmp_path)


def test_missing_values_stay_until_they_are_cleaned(tmp_path):
    state = [*STATE[:1], [np.nan, 0.0], *STATE[2:]]
    path = save(tmp_path / "gaps.parquet", state)
    refused(r"sample 1, column 'observation.state'", lt.read_demonstrations, path)
    assert np.isnan(lt.io.read_recordings(path)[0].positions[1, 0])


ARM = lt.Arm.from_urdf(so101.URDF, tip=so101.TIP)
RANGES = dict(
    zip(ARM.joint_names, zip(ARM.limits.lower, ARM.limits.upper, strict=True), strict=True)
)
ENDING = np.array([0.0, 0.0, 0.0, 45.0, 0.0])


def data_set(folder, numbers, *, scale=1.0, stats=True):
    """A data set whose numbers are those that `numbers` makes of joints; and the joints."""
    shown = [(q * scale, opening) for q, opening in so101.motions()]
    so101.save(folder, [np.column_stack([numbers(q), opening]) for q, opening in shown])
    if not stats:
        (folder / "meta" / "stats.json").unlink()
    return [q for q, _ in shown]


def percent(q):
    return so101.percent(q, ARM.limits)


def read(folder, **more):
    return lt.read_demonstrations(folder, joints=RANGES, **more)


@pytest.mark.parametrize(("numbers", "unit"), [(np.degrees, "degrees"), (percent, "percent")])
def test_a_unit_that_is_stated_gives_the_arms_joints(tmp_path, numbers, unit):
    shown = data_set(tmp_path, numbers)
    found = read(tmp_path, angles=unit)
    assert [each.name for each in found] == ["episode_0", "episode_1", "episode_2"]
    for demonstration, q in zip(found, shown, strict=True):
        assert demonstration.motion.joint_names == so101.JOINTS
        np.testing.assert_allclose(demonstration.motion.positions, q, atol=1e-5)
        assert ARM.poses(demonstration.motion).joints is not None


@pytest.mark.parametrize("stats", [True, False])
def test_the_only_unit_that_fits_is_taken_for_the_whole_data_set(tmp_path, stats):
    # Beyond 100 there are no percent ...
    far = data_set(tmp_path / "degrees", np.degrees, scale=2.8, stats=stats)
    np.testing.assert_allclose(read(tmp_path / "degrees")[0].motion.positions, far[0], atol=1e-5)
    # ... but they stop there, where a joint comes to its end.
    data_set(tmp_path / "percent", lambda q: np.minimum(percent(q) + ENDING, 100.0), stats=stats)
    for each in read(tmp_path / "percent"):
        assert each.motion.positions[-1, 3] == pytest.approx(ARM.limits.upper[3], abs=1e-5)


def test_degrees_beyond_the_limits_of_the_joints_can_only_be_percent(tmp_path):
    shown = data_set(tmp_path, percent)
    narrow = dict.fromkeys(RANGES, (-0.9, 0.9))
    found = lt.read_demonstrations(tmp_path, joints=narrow)[0].motion.positions
    np.testing.assert_allclose(found, 0.009 * percent(shown[0]), atol=1e-5)


def test_where_both_units_fit_the_message_says_what_to_state(tmp_path):
    data_set(tmp_path, percent)
    refused("both fit; set angles='degrees' or angles='percent'", read, tmp_path)
    with pytest.raises(
        InvalidInput, match=r"angles: percent refer to the limits.*; in Python, set joints"
    ):
        lt.read_demonstrations(tmp_path, angles="percent")


def test_without_an_arm_the_motors_keep_their_names_and_joints_of_finds_them(tmp_path):
    (shown, *_) = data_set(tmp_path, np.degrees)
    motion = lt.read_demonstrations(tmp_path, angles="degrees")[0].motion
    assert motion.joint_names == tuple(so101.MOTORS)
    own = ARM.joints_of(motion)
    assert own.joint_names == so101.JOINTS
    np.testing.assert_allclose(own.positions, shown, atol=1e-5)


def test_a_gripper_that_closes_is_an_event_and_one_that_rests_is_none(tmp_path):
    data_set(tmp_path / "closes", np.degrees)
    for each in read(tmp_path / "closes", angles="degrees"):
        (event,) = each.events
        assert event.name == "close gripper"
        assert event.time == pytest.approx(0.7 * 89 / so101.FPS, abs=0.04)
    still = [np.column_stack([np.degrees(q), 50.0 + 0.0 * o]) for q, o in so101.motions()]
    so101.save(tmp_path / "rests", still)
    assert all(each.events == () for each in read(tmp_path / "rests", angles="degrees"))


def test_a_gripper_among_the_joints_goes_from_0_to_100(tmp_path):
    data_set(tmp_path, percent)
    whole = RANGES | {"gripper": (-0.2, 1.8)}
    found = lt.read_demonstrations(tmp_path, joints=whole, angles="percent")[0].motion
    assert found.joint_names == (*so101.JOINTS, "gripper")
    np.testing.assert_allclose(found.positions[[0, -1], -1], [1.4, -0.1], atol=1e-6)


def test_damaged_statistics_are_left_aside(tmp_path):
    for wrong in ("{", "[]", '{"observation.state": {"min": [1], "max": "x"}}'):
        folder = tmp_path / str(len(wrong))
        far = data_set(folder, np.degrees, scale=2.8)
        (folder / "meta" / "stats.json").write_text(wrong)
        np.testing.assert_allclose(read(folder)[0].motion.positions, far[0], atol=1e-5)


@pytest.mark.parametrize("wrong", [3, {"a": (1.0,)}, {"a": (2.0, 1.0)}, {1: (0.0, 1.0)}])
def test_ranges_that_are_none_are_refused(tmp_path, wrong):
    data_set(tmp_path, np.degrees)
    refused("joints", lt.read_demonstrations, tmp_path, joints=wrong)


def test_an_arms_joints_are_found_by_its_names_in_any_table(tmp_path):
    rows = np.column_stack([np.arange(3) / 10.0, np.eye(3), np.arange(3)])
    path = tmp_path / "a.csv"
    np.savetxt(path, rows, delimiter=",", header="time,lift,pan,x,y", comments="")
    (found,) = lt.read_demonstrations(path, joints={"pan": (-1.0, 1.0), "lift": (-1.0, 1.0)})
    assert found.motion.joint_names == ("pan", "lift")
    np.testing.assert_allclose(found.motion.positions, rows[:, [2, 1]])


def test_a_data_set_of_two_arms_is_a_demonstration_of_both(tmp_path):
    """The right arm's joints come first, and its gripper among them."""
    pair = two_pandas()
    names = ["right_gripper", *pair.joint_names[7:], *pair.joint_names[:7]]
    state = np.linspace(-0.1, -0.2, 6)[:, None] * np.arange(15.0) / 5.0
    state[:, 0] = 0.0
    save(tmp_path / "data" / "chunk-000" / "file-000.parquet", state.tolist())
    describe(tmp_path, [f"{name}.pos" for name in names])
    shown = pair.demonstration(lt.read_demonstrations(tmp_path, angles="radians")[1])
    wanted = np.hstack([state[3:, 8:], state[3:, 1:8]])
    np.testing.assert_allclose(shown.joints.positions, wanted, atol=1e-6)
    assert (shown.name, len(shown.right)) == ("episode_5", 3)
