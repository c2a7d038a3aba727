"""Every writer, read back."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from motions import minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io.robot_programs import write_franka, write_urscript

NUMBER = r"-?\d+\.\d+"


def written_and_read(motion, path):
    lt.write_motion(motion, path)
    return lt.read_motion(path)


def assert_same_joints(back, motion):
    for name in ("positions", "velocities", "accelerations"):
        assert np.array_equal(getattr(back, name), getattr(motion, name))
    assert back.joint_names == motion.joint_names
    assert [event.name for event in back.events] == [event.name for event in motion.events]


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_joints_come_back_to_the_same_bits(tmp_path, ur_motion, suffix):
    back = written_and_read(ur_motion, tmp_path / f"arm{suffix}")
    assert_same_joints(back, ur_motion)
    assert np.array_equal(back.times, ur_motion.times)
    assert back.events == ur_motion.events


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_poses_and_points_come_back_to_the_same_bits(tmp_path, poses, suffix):
    pen = lt.Trajectory([0.0, 0.1], [[1 / 3, 2.0], [3.0, 4e-20]], (lt.Event(0.1, "pen\nup"),))
    for motion in (poses, pen):
        back = written_and_read(motion, tmp_path / f"motion{suffix}")
        assert np.array_equal(back.times, motion.times)
        assert np.array_equal(back.positions, motion.positions)
        assert back.events == motion.events
        if motion is poses:  # its quaternions are normalised anew
            np.testing.assert_allclose(back.orientations, motion.orientations, atol=1e-15)


@pytest.mark.parametrize("suffix", [".json", ".yaml", ".mcap"])
def test_controller_messages_come_back_a_step_later(tmp_path, ur_motion, suffix):
    back = written_and_read(ur_motion, tmp_path / f"arm{suffix}")
    np.testing.assert_allclose(back.times, ur_motion.times + 0.01, atol=1e-9)
    assert_same_joints(back, ur_motion)


def test_yaml_holds_what_json_holds(tmp_path, ur_motion):
    for suffix in ("json", "yaml"):
        lt.write_motion(ur_motion, tmp_path / f"arm.{suffix}")
    text = (tmp_path / "arm.yaml").read_text()
    assert yaml.safe_load(text) == json.loads((tmp_path / "arm.json").read_text())
    assert len(text.splitlines()) < 6 * len(ur_motion.times)


@pytest.mark.parametrize("value", [1e-5, -3e20, 1.25e-7, 0.1, 5e-324, 12e-9])
def test_small_numbers_stay_numbers_in_yaml(tmp_path, ur_motion, value):
    moved = replace(ur_motion, positions=ur_motion.positions * 0.0 + value)
    lt.write_motion(moved, tmp_path / "arm.yaml")
    assert np.array_equal(lt.read_motion(tmp_path / "arm.yaml").positions, moved.positions)


def test_names_of_any_kind_survive_yaml(tmp_path, ur_motion):
    names = ("a: b", "*c", "&d", "ünï 🦾", '"', "[e")
    events = (lt.Event(0.5, "close *fast* & firmly\n"),)
    lt.write_motion(replace(ur_motion, joint_names=names, events=events), tmp_path / "arm.yaml")
    back = lt.read_motion(tmp_path / "arm.yaml")
    assert back.joint_names == names
    assert back.events[0].name == events[0].name


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "not a readable trajectory_msgs/JointTrajectory"),
        ('{"trajectory": {}}', "'joint_names' or 'points' is missing"),
        ("{}", "not a readable trajectory_msgs/JointTrajectory .'joint_names'"),
        ('{"joint_names": ["a"], "points": []}', "at least one point"),
        ('{"joint_names": ["a", "a"], "points": [1]}', "different joint_names"),
        ('{"joint_names": ["a"], "points": [{"positions": [1, 2], "time_from_start": {"sec": 0, '
         '"nanosec": 1}}]}', "positions: expected 1 numbers, one per joint, at point 0"),
        ('{"joint_names": ["a"], "points": [{"positions": [true], "time_from_start": {"sec": 0, '
         '"nanosec": 1}}]}', "positions: expected numbers, got True"),
        ('{"joint_names": ["a"], "points": [{"positions": [1e999], "time_from_start": {"sec": 0, '
         '"nanosec": 1}}]}', "expected a finite number|expected numbers"),
        ("[" * 100_000, "not a readable trajectory_msgs/JointTrajectory|nests at most 16 deep"),
        ("9" * 5000, "not a readable trajectory_msgs/JointTrajectory"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("suffix", [".json", ".yaml"])
def test_what_is_no_controller_message_is_refused(tmp_path, text, message, suffix):
    path = tmp_path / f"arm{suffix}"
    path.write_text(text)
    refused(message, lt.read_demonstrations, path)


def test_a_list_that_mentions_itself_is_refused(tmp_path):
    path = tmp_path / "bomb.yaml"
    path.write_text("? " * 10_000 + "a\n")
    refused("nests at most 16 deep", lt.read_demonstrations, path)
    path.write_text("a: &a [1, 2]\nb: &b [*a, *a]\npoints: [*b, *b]\njoint_names: [x]\n")
    refused("without aliases", lt.read_demonstrations, path)


def test_a_ur_program_has_a_step_for_each_cycle(tmp_path, ur_motion):
    shuffled = [3, 1, 0, 5, 4, 2]
    other = lt.JointTrajectory(
        ur_motion.times,
        ur_motion.positions[:, shuffled],
        ur_motion.velocities[:, shuffled],
        joint_names=[f"left_{ur_motion.joint_names[i]}" for i in shuffled],
        events=ur_motion.events,
    )
    write_urscript(other, tmp_path / "arm.script", rate=500, lookahead=0.05, gain=400)
    lines = (tmp_path / "arm.script").read_text().splitlines()
    assert (lines[0], lines[-2:]) == ("def leadthrough():", ["  stopj(1.0)", "end"])
    moves = [line for line in lines if "servoj" in line]
    assert all(line.endswith("], 0, 0, 0.002, 0.05, 400.0)") for line in moves)
    first = re.findall(NUMBER, next(line for line in lines if "movej" in line))[:6]
    rows = np.array([first, *(re.findall(NUMBER, line)[:6] for line in moves)], float)
    assert len(rows) == 501
    np.testing.assert_allclose(rows[::5], ur_motion.positions, atol=1e-9)
    logged = [i for i, line in enumerate(lines) if "textmsg" in line]
    assert [lines[i] for i in logged] == [
        '  textmsg("close gripper")',
        "  textmsg(\"say 'done'\")",
    ]
    assert sum("servoj" in line for line in lines[: logged[0]]) == 125
    assert sum("servoj" in line for line in lines[: logged[1]]) == 450


def test_a_franka_table_has_a_row_for_each_millisecond(tmp_path, panda_motion):
    write_franka(panda_motion, tmp_path / "arm.csv")
    back = lt.read_motion(tmp_path / "arm.csv")
    assert np.array_equal(back.times, np.arange(1001) / 1000)
    np.testing.assert_allclose(back.positions[::10], panda_motion.positions, atol=1e-12)
    np.testing.assert_allclose(back.velocities[::10], panda_motion.velocities, atol=1e-12)
    assert back.joint_names == tuple(f"q_d[{i}]" for i in range(7))
    assert back.events == panda_motion.events


def test_between_samples_a_controller_gets_the_smooth_motion(tmp_path, panda_motion):
    write_franka(panda_motion, tmp_path / "arm.csv")
    s = np.arange(1001) / 1000
    shape = minimum_jerk(s)
    way = panda_motion.positions[-1] - panda_motion.positions[0]
    expected = panda_motion.positions[0] + np.outer(shape, way)
    assert np.abs(lt.read_motion(tmp_path / "arm.csv").positions - expected).max() < 1e-7


def test_samples_at_the_rate_already_stay_as_they_are(tmp_path, panda_motion, joints_of):
    kilohertz = joints_of(panda_motion.joint_names, count=1001)
    write_franka(kilohertz, tmp_path / "arm.csv")
    assert np.array_equal(lt.read_motion(tmp_path / "arm.csv").positions, kilohertz.positions)


def test_a_motion_that_ends_between_cycles_is_held(tmp_path, panda_motion):
    times = panda_motion.times * 0.9997
    write_franka(replace(panda_motion, times=times, events=()), tmp_path / "arm.csv")
    back = lt.read_motion(tmp_path / "arm.csv")
    assert back.times[-1] == 1.0
    assert np.array_equal(back.positions[-1], panda_motion.positions[-1])
    assert not back.velocities[-1].any()


def test_only_the_right_arm_gets_a_program(tmp_path, ur_motion, panda_motion):
    refused("joints of a UR arm", lt.write_motion, panda_motion, tmp_path / "arm.script")
    with pytest.raises(InvalidInput, match="7 joints whose names end in 1 to 7"):
        lt.write_motion(ur_motion, tmp_path / "arm.csv", format="franka")
    still_moving = replace(ur_motion, velocities=ur_motion.velocities + 1.0)
    with pytest.raises(InvalidInput, match="expected rest at the first sample"):
        lt.write_motion(still_moving, tmp_path / "arm.script")
    with pytest.raises(InvalidInput, match="expected velocities"):
        lt.write_motion(replace(ur_motion, velocities=None), tmp_path / "arm.script")
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_written_is_said(tmp_path, ur_motion):
    for options in [{"rate": 0}, {"rate": 1000}, {"lookahead": 1}, {"gain": 1}, {"name": "a b"}]:
        refused(next(iter(options)), write_urscript, ur_motion, tmp_path / "arm.script", **options)
    for path, format, message in [
        ("arm.xyz", None, r"path: expected .csv, .* got '.xyz'"),
        ("arm.mat", None, r"path: expected .csv, .* got '.mat'"),
        ("arm.csv", "word", "format: expected one of 'csv', 'npz'"),
        ("arm.csv", "mat", "format: expected one of 'csv', 'npz'"),
        (None, None, "path: expected a path"),
    ]:
        refused(message, lt.write_motion, ur_motion, path, format=format)
        refused("motion: expected a Trajectory", lt.write_motion, [1, 2], "arm.csv")


def carrying(kind, names=("pan", "panda_joint2", "joint_3")):
    """A motion of the tip with the joints that an arm was shown with."""
    times = np.linspace(0.0, 1.0, 11)
    rows = np.outer(times, [1.0, -0.5, 2.0]) + 0.1
    joints = lt.JointTrajectory(times, rows, joint_names=names)
    if kind == "points":
        return lt.Trajectory(times, rows, joints=joints)
    turned = lt.rotations.exp(np.outer(times, [0.1, 0.2, 0.3]))
    return lt.PoseTrajectory(times, rows, turned, joints=joints)


@pytest.mark.parametrize("suffix", ["csv", "npz"])
@pytest.mark.parametrize("kind", ["points", "poses"])
def test_joints_beside_a_motion_of_the_tip_are_kept(tmp_path, kind, suffix):
    motion = carrying(kind)
    found = written_and_read(motion, tmp_path / f"motion.{suffix}")
    assert type(found) is type(motion)
    assert found.joints.joint_names == motion.joints.joint_names
    np.testing.assert_array_equal(found.joints.positions, motion.joints.positions)
    (shown,) = lt.read_demonstrations(tmp_path / f"motion.{suffix}")
    assert shown.motion.joints.joint_names == motion.joints.joint_names


def test_joints_that_are_faulty_or_without_names_are_left_out(tmp_path):
    assert written_and_read(carrying("poses", names=()), tmp_path / "a.csv").joints is None
    lt.write_motion(carrying("poses"), tmp_path / "b.csv")
    lines = (tmp_path / "b.csv").read_text().splitlines()
    lines[3] = lines[3].rpartition(",")[0] + ","
    (tmp_path / "b.csv").write_text("\n".join(lines))
    assert lt.read_motion(tmp_path / "b.csv").joints is None
    with pytest.raises(InvalidInput, match="different, printable joint_names"):
        lt.write_motion(carrying("poses", names=("a", "a", "b")), tmp_path / "c.csv")


@pytest.mark.parametrize("suffix", [".csv", ".json", ".yaml"])
def test_texts_of_several_blocks_are_read_back_and_damaged_ones_refused(tmp_path, suffix):
    times = np.arange(8000) / 1000.0
    q = np.random.default_rng(0).normal(size=(3, 8000, 4))
    q[1, [0, -1]] = 0.0
    names = ("a", "b", "c", "d")
    happens = (lt.Event(4.0, "close"),)
    motion = lt.JointTrajectory(times, *q, joint_names=names, events=happens)
    path = tmp_path / f"motion{suffix}"
    lt.write_motion(motion, path)
    assert path.stat().st_size > 2**20
    found = lt.read_motion(path)
    assert found.joint_names == names
    assert [event.name for event in found.events] == ["close"]
    for name in ("positions", "velocities", "accelerations"):
        assert np.array_equal(getattr(found, name), getattr(motion, name))
    text = path.read_text()
    middle = text.index(",", len(text) // 2)
    path.write_text(f"{text[:middle]},x{text[middle:]}")
    with pytest.raises(lt.errors.InvalidInput):
        lt.read_motion(path)
