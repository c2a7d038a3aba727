"""Wrong units on the command line: refused or warned of in the words of the options."""

import numpy as np
import pytest
from cli.command_line import run

import leadthrough as lt


@pytest.fixture(autouse=True)
def _reach(folder):
    run("learn", "recorded", "-o", "reach.npz")


def test_a_goal_in_millimetres_is_refused(folder):
    told = run("plan", "reach.npz", "--goal", "300,200,250", "-o", "x.json", code=2).stderr
    assert "--goal: (300, 200, 250) lies" in told
    assert "m, not mm" in told


def test_a_goal_out_of_reach_says_by_how_much(folder):
    told = run("plan", "reach.npz", "--goal", "0.9,0.5,0.4", "-o", "x.json", code=1).stderr
    assert "beyond the arm's reach of" in told


def test_an_obstacle_in_millimetres_is_warned_of(folder):
    told = run("plan", "reach.npz", "--obstacle", "sphere:50@300,0,400", "-o", "x.json").stderr
    assert "warning: --obstacle[0]: lies at" in told or "warning: --obstacle: lies at" in told


def test_a_step_in_milliseconds_is_refused(folder):
    told = run("plan", "reach.npz", "--dt", "10", "-o", "x.json", code=2).stderr
    assert "--dt: expected at most the motion's duration" in told


def test_degrees_are_refused_with_the_option_that_cures_it(folder):
    arm = lt.Arm.load("ur3")
    q = np.degrees(np.outer(np.linspace(0.0, 1.0, 100), np.full(6, 0.19)))
    lt.write_motion(
        lt.JointTrajectory(np.arange(100) / 50, q, joint_names=arm.joint_names), "d.csv"
    )
    told = run("learn", "d.csv", "-o", "x.npz", code=2).stderr
    assert "--angles degrees" in told
    run("learn", "d.csv", "--angles", "degrees", "-o", "x.npz")


def test_another_tip_than_the_one_shown_is_warned_of(folder):
    urdf = (folder / "ur3.urdf").read_text()
    moved = urdf.replace('<link name="tool0"/>', '<link name="tool0"/><link name="far"/>').replace(
        "</robot>",
        '<joint name="to_far" type="fixed"><parent link="tool0"/><child link="far"/>'
        '<origin xyz="0 0 0.15"/></joint></robot>',
    )
    (folder / "longer.urdf").write_text(moved)
    words = ("--robot", "longer.urdf", "--tip", "far", "--limits", "ur3.toml", "-o", "x.json")
    told = run("plan", "reach.npz", *words).stderr
    assert "warning: --robot: with the demonstrated joints" in told
    assert "warning" not in run("plan", "reach.npz", "-o", "x.json").stderr
