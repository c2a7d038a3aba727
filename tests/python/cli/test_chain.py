"""From recordings to a checked motion, by commands alone, with an arm that is not among ours."""

from pathlib import Path

import numpy as np
import pytest
from cli.command_line import facts, run, write_limits, write_table
from foreign_arms import urdf_in_package
from motions import minimum_jerk

import leadthrough as lt

UR5 = urdf_in_package("example-robot-data", "ur5_robot.urdf")
ROBOT = ("--robot", UR5, "--tip", "tool0")
LIMITED = (*ROBOT, "--limits", "ur5.toml")
HOME = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])


def record(path, arm, seed):
    """A reach of an arm as a CSV of its joints at 100 Hz, a little different each time."""
    rng = np.random.default_rng(seed)
    times = np.arange(0.0, 2.0, 0.01)
    share = minimum_jerk(times / times[-1])
    turn = np.array([0.8, -0.4, 0.5, -0.3, 0.4, 0.6]) + rng.normal(0, 0.02, 6)
    rows = np.column_stack([times, HOME + share[:, None] * turn])
    write_table(path, ",".join(["time", *arm.joint_names]), rows)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with a limits file, three recordings and skills of joints and of poses."""
    folder = tmp_path_factory.mktemp("chain")
    arm = lt.Arm.from_urdf(UR5, tip="tool0")
    write_limits(folder / "ur5.toml", arm.joint_names, head='robot = "ur5"\n')
    for number in range(3):
        record(folder / f"shown{number}.csv", arm, number)
    run("learn", folder / "shown0.csv", "-o", folder / "joints.npz")
    run("learn", folder / "shown0.csv", *ROBOT, "-o", folder / "poses.npz")
    return folder, arm


@pytest.fixture
def shown(written, monkeypatch):
    """The arm that is shown; the folder is the working directory."""
    folder, arm = written
    monkeypatch.chdir(folder)
    return arm


def rows_of(name):
    return np.loadtxt(name, delimiter=",", skiprows=1)[:, 1:]


def test_urdf_and_joint_recordings_become_a_checked_motion(shown):
    csvs = [f"shown{number}.csv" for number in range(3)]
    learned = facts("learn", *csvs, *LIMITED, "-o", "reach.npz")
    assert learned["model"] == min(learned["left_out_errors"], key=learned["left_out_errors"].get)
    assert learned["demonstrations"] == ["shown0", "shown1", "shown2"]

    plain = lt.load_skill("reach.npz").generate()
    wanted = ("--posture", ",".join(map(str, HOME)), "--move-goal=0.03,0,0.02")
    planned = facts("plan", "reach.npz", *LIMITED, *wanted, "-o", "m.json")
    assert planned["type"] == "JointTrajectory"
    motion = lt.read_motion("m.json")
    tip = shown.poses(motion)
    asked = plain.positions[-1] + [0.03, 0.0, 0.02]
    assert np.abs(tip.positions[-1] - asked).max() < 1e-4

    timed = facts("retime", "m.json", *LIMITED, "--rate", "500", "-o", "t.json")
    assert timed["duration"] < timed["duration_before"]
    assert timed["limited_by"]
    verdict = facts("check", "t.json", *LIMITED)
    assert verdict["ok"]
    assert verdict["acceleration_used"]["ratio"] <= 1.001
    where = ",".join(f"{x:.3f}" for x in tip.positions[100])
    hit = facts("check", "t.json", *LIMITED, "--obstacle", f"sphere:0.05@{where}", code=1)
    assert hit["limits_kept"]
    assert not hit["clear"]
    assert hit["nearest_obstacle"]["distance"] < -0.04


def test_joints_are_learned_as_joints_without_a_robot(shown):
    assert facts("learn", "shown0.csv", "-o", "j.npz", "--model", "dmp", "--set", "weights=30")
    assert lt.load_skill("j.npz").model.weights == 30
    facts("plan", "j.npz", "--duration", "3", "-o", "j.csv")
    motion = lt.read_motion("j.csv")
    assert motion.joint_names == shown.joint_names
    assert motion.duration == pytest.approx(3.0)


def test_recordings_are_cut_at_pauses_and_one_is_chosen(shown):
    rest = np.repeat(HOME[None], 100, axis=0)
    first, second = rows_of("shown0.csv"), rows_of("shown1.csv")
    whole = np.vstack([rest, first, first[:0:-1], rest, second, rest + second[-1] - HOME])
    write_table("day.csv", ",".join(shown.joint_names), whole)
    result = run("learn", "day.csv", "--rate", 100, "--cut", "--motion", 2, *ROBOT, "-o", "s.npz")
    assert "motion 2: day 2" in result.stderr
    assert "motion 3" not in result.stderr
    skill = lt.load_skill("s.npz")
    goal, _ = shown.forward_kinematics(second[-1])
    assert np.abs(skill.generate().positions[-1] - goal).max() < 2e-3


def test_the_arm_stands_as_it_was_shown_to(shown):
    facts("plan", "poses.npz", *LIMITED, "--posture", "shown0.csv", "-o", "m.json")
    motion = lt.read_motion("m.json")
    # An arm of six joints has no null space: the same branch is the same joints.
    assert np.abs(motion.positions[[0, -1]] - rows_of("shown0.csv")[[0, -1]]).max() < 0.01


def test_faulty_recordings_are_cleaned_and_said_to_be(shown):
    lines = Path("shown0.csv").read_text().splitlines()
    lines[50] = ",".join(["nan"] * 7)
    lines[60] = lines[61]
    Path("faulty.csv").write_text("\n".join(lines))
    run("learn", "faulty.csv", "-o", "s.npz", code=2)
    assert "faulty: " in run("learn", "faulty.csv", "--clean", "-o", "s.npz").stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["learn", "none.csv"], "none.csv: no such file"),
        (["learn", "shown0.csv", "--set", "weights=9"], "--set: only used with --model"),
        (["learn", "shown0.csv", "--model=dmp", "--set", "weights=0"], "--set weights: "),
        (["learn", "shown0.csv", "--rate", "9"], "shown0.csv: --rate: "),
        (["learn", "shown0.csv", "--column", "joints=a"], "--column joints: "),
        (["learn", "shown0.csv", "--motion", "2"], "--motion: expected a number from 1 to 1"),
        (["learn", "shown0.csv", "--robot", "panda"], "panda_joint1"),
        (["retime", "shown0.csv", *ROBOT], "jerk"),
        (["check", "shown0.csv", "--robot", "ur3", "--obstacle", "box:1@0,0,0"], "3 sizes"),
        (["check", "shown0.csv", "--robot", "ur3", "--obstacle", "box:1,1,x@0,0,0"], "x"),
        (["plan", "none.npz"], "none.npz: no such file"),
        (["plan", "shown0.csv"], "shown0.csv: "),
        (["plan", "poses.npz", "--goal", "1,2"], "goal"),
        (["plan", "poses.npz", "--goal", "nan,0,0"], "goal"),
        (["plan", "poses.npz", "--goal", "0,0,0/0,0,0,0"], "goal"),
        (["plan", "poses.npz", "--start", "0,0,0/1,0"], "start"),
        (["plan", "poses.npz", "--move-goal", "1,2"], "--move-goal: expected 3"),
        (
            ["plan", "poses.npz", "--posture", "0,0", "--robot", "panda"],
            "--posture: expected shape (7,)",
        ),
        (["plan", "poses.npz", "--posture", "0,0,0,0,0,0"], "--posture: only used with --robot"),
        (["plan", "poses.npz", "--limits", "ur5.toml"], "--limits: only used with --robot"),
        (
            ["plan", "joints.npz", "--goal", "0,0,0,0,0,0/1,0,0,0"],
            "--goal: expected no orientation",
        ),
        (
            ["plan", "joints.npz", "--goal", "0,0,0,0,0,0", "--move-goal", "0,0,0,0,0,0"],
            "--move-goal, got both",
        ),
    ],
)
def test_wrong_words_are_told_in_one_line(shown, words, says):
    output = [] if words[0] == "check" else ["-o", "refused.npz" if "learn" in words else "m.csv"]
    result = run(*words, *output, code=2)
    assert says in result.stderr
    assert "Traceback" not in result.output
    assert not Path("m.csv").exists()


def test_what_cannot_be_had_ends_with_one(shown):
    result = run("plan", "poses.npz", *ROBOT, "--move-goal=3,0,0", "-o", "far.json", code=1)
    assert "no configuration" in result.stderr or "reach" in result.stderr
    assert not Path("far.json").exists()


def planned(skill, goal):
    """The motion that is planned to a goal, given in words."""
    run("plan", skill, "--goal", goal, "-o", "made.npz")
    return lt.read_motion("made.npz")


def test_a_goal_without_an_orientation_keeps_the_one_shown(shown):
    plain = lt.load_skill("poses.npz").generate()
    goal = plain.positions[-1] + [0.02, 0.0, 0.01]
    made = planned("poses.npz", ",".join(map(str, goal)))
    np.testing.assert_allclose(made.positions[-1], goal, atol=1e-9)
    turn = lt.rotations.distance(made.orientations[-1:], plain.orientations[-1:])
    assert turn[0] < 1e-9


def test_a_goal_of_joints_or_with_an_orientation_is_reached(shown):
    made = planned("joints.npz", ",".join(map(str, HOME)))
    np.testing.assert_allclose(made.positions[-1], HOME, atol=1e-9)
    posed = planned("poses.npz", "0.3,0.3,0.4/0,1,0,0")
    assert lt.rotations.distance(posed.orientations[-1:], [[0.0, 1.0, 0.0, 0.0]])[0] < 1e-6


@pytest.mark.parametrize(("model", "within"), [("dmp", 1e-4), ("fast-marching", 1e-3)])
def test_a_real_recording_is_replayed_to_a_moved_goal(
    recordings, tmp_path, monkeypatch, model, within
):
    monkeypatch.chdir(tmp_path)
    trial = recordings / "panda_execution" / "trial1.csv"
    joints = "joints=" + ",".join(f"joint_{i}" for i in range(1, 8))
    one = ("--rate", 20, "--column", joints, "--cut", "--motion", 11, "--robot", "panda")
    run("learn", trial, *one, "--model", model, "-o", "skill.npz")
    shown = lt.load_skill("skill.npz").generate()
    moved = ("--robot", "panda", "--move-goal=0.02,-0.02,0.01")
    run("plan", "skill.npz", *moved, "-o", "motion.json")
    run("retime", "motion.json", "--robot", "panda", "-o", "timed.npz")
    verdict = facts("check", "timed.npz", "--robot", "panda")
    assert verdict["ok"]
    timed = lt.read_motion("timed.npz")
    reached = lt.Arm.load("panda").poses(timed).positions[-1]
    assert np.abs(reached - (shown.positions[-1] + [0.02, -0.02, 0.01])).max() < within


@pytest.mark.parametrize("trial", ["trial1.csv", "trial2.csv"])
def test_a_log_of_five_minutes_is_learned_within_two_millimetres(recordings, tmp_path, trial):
    """Its curve had 3,200 rows at most, and was 2.1 mm off."""
    joints = "joints=" + ",".join(f"joint_{i}" for i in range(1, 8))
    how = ("--rate", 20, "--column", joints, "--robot", "panda", "-o", tmp_path / "skill.npz")
    learned = facts("learn", recordings / "panda_execution" / trial, *how)
    assert learned["reproduction"]["position"] < 2e-3


@pytest.mark.parametrize("noise", [3e-6, 3e-8])
def test_noise_is_smoothed_that_the_fitted_path_would_follow_sample_by_sample(shown, noise):
    times = np.arange(0.0, 4.0, 0.005)
    share = minimum_jerk(times / times[-1])[:, None]
    rows = HOME + 0.5 * share + np.random.default_rng(0).normal(0.0, noise, (len(times), 6))
    write_table(
        Path("fine.csv"), ",".join(["time", *shown.joint_names]), np.column_stack([times, rows])
    )
    found = facts("retime", "fine.csv", *LIMITED, "--keep-timing", "-o", "kept.npz")
    assert found.get("smoothed", 0.0) == pytest.approx(noise if noise > 1e-7 else 0.0, rel=0.2)
    assert found["duration"] == pytest.approx(times[-1], abs=0.1)
