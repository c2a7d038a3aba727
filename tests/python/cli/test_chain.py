"""From recordings to a checked motion, by commands alone, with an arm that is not among ours."""

import importlib.metadata
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import facts, run
from motions import minimum_jerk

import leadthrough as lt

(UR5,) = (
    entry.locate()
    for entry in importlib.metadata.distribution("example-robot-data").files
    if entry.name == "ur5_robot.urdf"
)
HOME = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])


def record(path, arm, seed):
    """A reach of an arm as a CSV of its joints at 100 Hz, a little different each time."""
    rng = np.random.default_rng(seed)
    times = np.arange(0.0, 2.0, 0.01)
    share = minimum_jerk(times / times[-1])
    turn = np.array([0.8, -0.4, 0.5, -0.3, 0.4, 0.6]) + rng.normal(0, 0.02, 6)
    rows = np.column_stack([times, HOME + share[:, None] * turn])
    header = ",".join(["time", *arm.joint_names])
    np.savetxt(path, rows, delimiter=",", header=header, comments="")


@pytest.fixture
def shown(tmp_path, monkeypatch):
    """A folder with a limits file and three recordings, as the working directory."""
    monkeypatch.chdir(tmp_path)
    arm = lt.Arm.from_urdf(UR5, tip="tool0")
    limits = "\n".join(
        f"{name} = {{ acceleration = 10.0, jerk = 100.0 }}" for name in arm.joint_names
    )
    Path("ur5.toml").write_text(f'robot = "ur5"\n[joints]\n{limits}\n')
    for number in range(3):
        record(f"shown{number}.csv", arm, number)
    return arm


def test_urdf_and_joint_recordings_become_a_checked_motion(shown):
    robot = ("--robot", UR5, "--tip", "tool0", "--limits", "ur5.toml")
    csvs = [f"shown{number}.csv" for number in range(3)]
    learned = facts("learn", *csvs, *robot, "-o", "reach.npz")
    assert learned["model"] == "dmp"
    assert learned["demonstrations"] == ["shown0", "shown1", "shown2"]

    plain = lt.load_skill("reach.npz").generate()
    posture = ",".join(map(str, HOME))
    planned = facts(
        "plan", "reach.npz", *robot, "--posture", posture, "--move-goal=0.03,0,0.02", "-o", "m.json"
    )
    assert planned["type"] == "JointTrajectory"
    motion = lt.read_motion("m.json")
    tip = shown.poses(motion)
    asked = plain.positions[-1] + [0.03, 0.0, 0.02]
    assert np.abs(tip.positions[-1] - asked).max() < 1e-4

    timed = facts("retime", "m.json", *robot, "--rate", "500", "-o", "t.json")
    assert timed["duration"] < timed["duration_before"]
    assert timed["limited_by"]
    verdict = facts("check", "t.json", *robot)
    assert verdict["ok"]
    assert verdict["acceleration_used"]["ratio"] <= 1.001
    where = ",".join(f"{x:.3f}" for x in tip.positions[100])
    hit = facts("check", "t.json", *robot, "--obstacle", f"sphere:0.05@{where}", code=1)
    assert hit["limits_kept"]
    assert not hit["clear"]
    assert hit["nearest_obstacle"]["distance"] < -0.04


def test_joints_are_learned_as_joints_without_a_robot(shown):
    assert facts("learn", "shown0.csv", "-o", "j.npz", "--set", "weights=30")["model"] == "dmp"
    assert lt.load_skill("j.npz").model.weights == 30
    facts("plan", "j.npz", "--duration", "3", "-o", "j.csv")
    motion = lt.read_motion("j.csv")
    assert motion.joint_names == shown.joint_names
    assert motion.duration == pytest.approx(3.0)


def test_recordings_are_cut_at_pauses_and_one_is_chosen(shown):
    rest = np.repeat(HOME[None], 100, axis=0)
    rows = np.vstack(
        [np.loadtxt(f"shown{i}.csv", delimiter=",", skiprows=1)[:, 1:] for i in (0, 1)]
    )
    whole = np.vstack([rest, rows[:200], rows[199:0:-1], rest, rows[200:], rest + rows[-1] - HOME])
    np.savetxt("day.csv", whole, delimiter=",", header=",".join(shown.joint_names), comments="")
    robot = ("--robot", UR5, "--tip", "tool0")
    result = run("learn", "day.csv", "--rate", 100, "--cut", "--motion", 2, *robot, "-o", "s.npz")
    assert "motion 2: day 2" in result.stderr
    assert "motion 3" not in result.stderr
    skill = lt.load_skill("s.npz")
    goal, _ = shown.forward_kinematics(rows[-1])
    assert np.abs(skill.generate().positions[-1] - goal).max() < 2e-3


def test_the_arm_stands_as_it_was_shown_to(shown):
    robot = ("--robot", UR5, "--tip", "tool0", "--limits", "ur5.toml")
    facts("learn", "shown0.csv", *robot, "-o", "reach.npz")
    facts("plan", "reach.npz", *robot, "--posture", "shown0.csv", "-o", "m.json")
    motion = lt.read_motion("m.json")
    recorded = np.loadtxt("shown0.csv", delimiter=",", skiprows=1)[:, 1:]
    # An arm of six joints has no null space: the same branch is the same joints.
    assert np.abs(motion.positions[[0, -1]] - recorded[[0, -1]]).max() < 0.01


def test_faulty_recordings_are_cleaned_and_said_to_be(shown):
    lines = Path("shown0.csv").read_text().splitlines()
    lines[50] = ",".join(["nan"] * 7)
    lines[60] = lines[61]
    Path("faulty.csv").write_text("\n".join(lines))
    run("learn", "faulty.csv", "-o", "s.npz", code=2)
    assert "faulty: " in run("learn", "faulty.csv", "--clean", "-o", "s.npz").stderr


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["learn", "none.csv", "-o", "s.npz"], 2, "none.csv: no such file"),
        (["learn", "shown0.csv", "--model", "magic", "-o", "s.npz"], 2, "--model"),
        (["learn", "shown0.csv", "--set", "magic=3", "-o", "s.npz"], 2, "--set"),
        (["learn", "shown0.csv", "--set", "weights=0", "-o", "s.npz"], 2, "--set weights: "),
        (["learn", "shown0.csv", "--rate", "9", "-o", "s.npz"], 2, "shown0.csv: --rate: "),
        (["learn", "shown0.csv", "--column", "joints=a", "-o", "s.npz"], 2, "--column joints: "),
        (
            ["learn", "shown0.csv", "--motion", "2", "-o", "s.npz"],
            2,
            "--motion: expected a number from 1 to 1",
        ),
        (["learn", "shown0.csv", "--robot", "panda", "-o", "s.npz"], 2, "panda_joint1"),
        (["learn", "shown0.csv", "--robot", "r2d2", "-o", "s.npz"], 2, "--robot: expected"),
        (
            ["retime", "shown0.csv", "--robot", str(UR5), "--tip", "tool0", "-o", "t.json"],
            2,
            "jerk",
        ),
        (["check", "shown0.csv", "--robot", "ur3", "--obstacle", "box:1@0,0,0"], 2, "3 sizes"),
        (["check", "shown0.csv", "--robot", "ur3", "--obstacle", "cube:1@0,0,0"], 2, "sphere"),
        (["check", "shown0.csv", "--robot", "ur3", "--obstacle", "box:1,1,x@0,0,0"], 2, "x"),
    ],
)
def test_wrong_words_are_told_in_one_line(shown, words, code, says):
    result = run(*words, code=code)
    assert says in result.stderr
    assert "Traceback" not in result.output


def test_what_cannot_be_had_ends_with_one(shown):
    run("learn", "shown0.csv", "--robot", UR5, "--tip", "tool0", "-o", "s.npz")
    robot = ("--robot", UR5, "--tip", "tool0")
    result = run("plan", "s.npz", *robot, "--move-goal=3,0,0", "-o", "m.json", code=1)
    assert "no configuration" in result.stderr or "reach" in result.stderr
    assert not Path("m.json").exists()


def test_a_goal_without_an_orientation_keeps_the_one_shown(shown):
    run("learn", "shown0.csv", "--robot", UR5, "--tip", "tool0", "-o", "s.npz")
    plain = lt.load_skill("s.npz").generate()
    goal = plain.positions[-1] + [0.02, 0.0, 0.01]
    run("plan", "s.npz", "--goal", ",".join(map(str, goal)), "-o", "m.npz")
    made = lt.read_motion("m.npz")
    np.testing.assert_allclose(made.positions[-1], goal, atol=1e-9)
    turn = lt.rotations.distance(made.orientations[-1:], plain.orientations[-1:])
    assert turn[0] < 1e-9


def test_a_goal_of_joints_or_with_an_orientation_is_reached(shown):
    run("learn", "shown0.csv", "-o", "j.npz")
    run("plan", "j.npz", "--goal", ",".join(map(str, HOME)), "-o", "j.csv")
    made = lt.read_motion("j.csv")
    np.testing.assert_allclose(made.positions[-1], HOME, atol=1e-9)
    run("learn", "shown0.csv", "--robot", UR5, "--tip", "tool0", "-o", "p.npz")
    run("plan", "p.npz", "--goal", "0.3,0.3,0.4/0,1,0,0", "-o", "p.csv")
    posed = lt.read_motion("p.csv")
    assert lt.rotations.distance(posed.orientations[-1:], [[0.0, 1.0, 0.0, 0.0]])[0] < 1e-6


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--goal", "1,2"], "goal"),
        (["--goal", "nan,0,0"], "goal"),
        (["--goal", "a,0,0"], "--goal"),
        (["--goal", "0,0,0/0,0,0,0"], "goal"),
        (["--start", "0,0,0/1,0"], "start"),
        (["--move-goal", "1,2"], "--move-goal: expected 3"),
        (["--posture", "0,0", "--robot", "panda"], "--posture: expected shape (7,)"),
        (["--posture", "0,0,0,0,0,0"], "--posture: only used with --robot"),
        (["--limits", "ur5.toml"], "--limits: only used with --robot"),
        (["--dt", "0"], "--dt: "),
        (["--duration", "-1"], "--duration: "),
        (["--format", "pdf"], "--format: "),
    ],
)
def test_wrong_queries_are_told_in_one_line(shown, words, says):
    run("learn", "shown0.csv", "--robot", UR5, "--tip", "tool0", "-o", "s.npz")
    result = run("plan", "s.npz", *words, "-o", "m.csv", code=2)
    assert says in result.stderr
    assert not Path("m.csv").exists()


def test_an_orientation_is_refused_where_the_skill_takes_none(shown):
    run("learn", "shown0.csv", "-o", "j.npz")
    words = ["plan", "j.npz", "--goal", "0,0,0,0,0,0/1,0,0,0", "-o", "m.csv"]
    assert "--goal: expected no orientation" in run(*words, code=2).stderr


@pytest.mark.parametrize(
    ("file", "says"), [("none.npz", "none.npz: no such file"), ("shown0.csv", "shown0.csv: ")]
)
def test_a_file_that_holds_no_skill_is_named(shown, file, says):
    assert says in run("plan", file, "-o", "m.csv", code=2).stderr


def test_both_a_goal_and_an_offset_are_refused(shown):
    run("learn", "shown0.csv", "-o", "s.npz")
    words = ["plan", "s.npz", "--goal", "0,0,0,0,0,0", "--move-goal", "0,0,0,0,0,0", "-o", "m.csv"]
    assert "--move-goal, got both" in run(*words, code=2).stderr


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
