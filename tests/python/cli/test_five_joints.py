"""An SO-101, five joints and a gripper: from a LeRobot data set to a replay and to a moved goal."""

from pathlib import Path

import numpy as np
import pytest
import so101
from cli.command_line import facts, run, write_limits

import leadthrough as lt

MOVED = ("--move-goal=0.01,-0.014,0.01",)
ARM = ("--robot", "arm.urdf", "--tip", so101.TIP, "--limits", "arm.toml")


@pytest.fixture
def arm(tmp_path, monkeypatch):
    """The arm; its URDF, limits and a data set in percent lie in the working directory."""
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(so101.URDF)
    write_limits("arm.toml", so101.JOINTS)
    arm = lt.Arm.from_urdf("arm.urdf", tip=so101.TIP)
    episodes = [
        np.column_stack([so101.percent(q, arm.limits), opening]) for q, opening in so101.motions()
    ]
    so101.save(Path("recorded"), episodes)
    return arm


def test_three_commands_lead_to_a_replay_and_to_a_goal_moved_by_2_cm(arm):
    learned = facts("learn", "recorded", *ARM, "--angles", "percent", "-o", "pick.npz")
    assert learned["demonstrations"] == ["episode_0", "episode_1", "episode_2"]
    replay = facts("plan", "pick.npz", *ARM, "-o", "replay.json")
    moved = facts("plan", "pick.npz", *ARM, *MOVED, "-o", "moved.json")
    assert replay["orientation_error"] < 1e-3
    assert 1e-3 < moved["orientation_error"] < 0.03  # five joints cannot turn the tip anyhow
    assert len(moved["free_axes"]) == 1
    named = facts(
        "plan", "pick.npz", *ARM, *MOVED, "--free-axis", *moved["free_axes"], "-o", "n.csv"
    )
    assert named["orientation_error"] == pytest.approx(moved["orientation_error"], rel=1e-3)
    plain = lt.load_skill("pick.npz").generate()
    start = np.mean([q[0] for q, _ in so101.motions()], axis=0)
    for file, offset in (("replay", [0.0, 0.0, 0.0]), ("moved", [0.01, -0.014, 0.01])):
        motion = lt.read_motion(f"{file}.json")
        assert np.abs(motion.positions[0] - start).max() < 0.01
        reached = arm.poses(motion).positions[-1]
        assert np.abs(reached - plain.positions[-1] - offset).max() < 1e-5
    for planned in (replay, moved):
        assert planned["position_error"] < 1e-5
        assert planned["start_from_recorded"] < 0.01


def test_the_gripper_closes_on_the_way_to_the_controller(arm):
    facts("learn", "recorded", *ARM, "--angles", "percent", "-o", "pick.npz")
    facts("plan", "pick.npz", *ARM, "-o", "replay.csv")
    facts("retime", "replay.csv", *ARM, "--rate", "100", "-o", "timed.csv")
    assert facts("check", "timed.csv", *ARM)["ok"]
    for file in ("replay.csv", "timed.csv"):
        (event,) = lt.read_motion(file).events
        assert event.name == "close gripper"


def test_a_skill_of_joints_needs_no_inverse_kinematics(arm):
    facts("learn", "recorded", *ARM, "--angles", "percent", "--joints", "-o", "joints.npz")
    planned = facts("plan", "joints.npz", *ARM, "-o", "replay.csv")
    assert planned["type"] == "JointTrajectory"
    motion = lt.read_motion("replay.csv")
    assert motion.joint_names == so101.JOINTS
    mean = np.mean([q for q, _ in so101.motions()], axis=0)
    assert np.abs(motion.positions[[0, -1]] - mean[[0, -1]]).max() < 2e-3
    assert [event.name for event in motion.events] == ["close gripper"]


def test_axes_and_tolerances_are_set_by_options(arm):
    facts("learn", "recorded", *ARM, "--angles", "percent", "-o", "pick.npz")
    plan = ("plan", "pick.npz", *ARM, "--move-goal=0,0.02,0")
    free = facts(*plan, "--free-axis", "rx", "--free-axis", "rz", "-o", "free.json")
    assert free["position_error"] < 1e-5
    near = facts(*plan, "--tolerance", "0.003,0.05", "--free-axis", "rx", "-o", "near.json")
    assert near["position_error"] < 0.003
    for words, says in (
        (["--free-axis", "spin"], "--free-axis: expected one of"),
        (["--tolerance", "0.1"], "--tolerance: expected shape (2,)"),
        (["--tolerance", "0.1,-1"], "--tolerance: expected a finite number > 0"),
    ):
        assert says in run(*plan, *words, "-o", "m.json", code=2).stderr
    alone = run("plan", "pick.npz", "--free-axis", "rx", "-o", "m.csv", code=2).stderr
    assert "--free-axis: only used with --robot" in alone


def test_joints_are_only_learned_of_an_arm_and_from_joints(arm):
    words = ("learn", "recorded", "--angles", "degrees", "--joints", "-o", "s.npz")
    assert "--joints: only used with --robot" in run(*words, code=2).stderr
    t = np.arange(5.0)
    lt.write_motion(lt.Trajectory(t, np.column_stack([t, t, t])), "points.csv")
    words = ("learn", "points.csv", *ARM, "--joints", "-o", "s.npz")
    assert "--joints: expected recordings of joints" in run(*words, code=2).stderr


def test_a_data_set_whose_unit_is_open_names_the_option(arm):
    said = run("learn", "recorded", *ARM, "-o", "s.npz", code=2).stderr
    assert "--angles degrees or --angles percent" in said
