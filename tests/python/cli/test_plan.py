"""leadthrough plan: motions of a skill, of the tip alone and of the whole arm."""

import numpy as np
import pytest
from cli.command_line import facts, run

import leadthrough as lt

U = np.linspace(0.0, 1.0, 60)


@pytest.fixture
def skill(empty_folder):
    """A file with a skill whose starts deviate by 0.1 m along y, and the goals with them."""
    shown = [
        lt.Trajectory(2.0 * U, np.column_stack([U, y + 0.0 * U, 0.3 * U**2]))
        for y in (-0.1, 0.0, 0.1)
    ]
    lt.ProMP().fit(shown).save("skill.npz")
    return "skill.npz"


def stderr_of(*words):
    return run("plan", *words, "-o", "motion.csv").stderr


def test_an_end_three_deviations_off_is_warned_of(skill):
    assert "warning" not in stderr_of(skill)
    assert "warning" not in stderr_of(skill, "--move-start=0,0.2,0")
    said = stderr_of(skill, "--move-goal=0,0.8,0", "--move-start=0,0.1,0")
    assert "goal" in said and "standard deviations" in said and "demonstration" in said
    assert "warning: start" not in said
    deviations = float(said.split("goal: ")[1].split()[0])
    expected = lt.load_skill(skill).novelty(goal=(1.0, 0.8, 0.3))
    assert deviations == pytest.approx(expected, rel=0.01)
    assert deviations >= 3.0


def test_ends_that_were_never_shown_together_are_warned_of(skill):
    said = stderr_of(skill, "--move-start=0,0.25,0", "--move-goal=0,-0.25,0")
    assert "warning: start and goal together" in said


def test_skills_without_a_distribution_do_not_warn(skill):
    motion = lt.load_skill(skill).generate()
    lt.DMP().fit([motion]).save("dmp.npz")
    assert "warning" not in stderr_of("dmp.npz", "--move-goal=0,0.5,0")


def planned(*words):
    return facts("plan", *words, "-o", "motion.csv")


def test_a_goal_farther_on_takes_longer_and_says_why(empty_folder):
    """Twice as far along its own way: at most 1.3 times as fast as demonstrated."""
    rise = lt.trajectories.minimum_jerk_time_scaling(U)
    shown = lt.Trajectory(2.0 * U, np.outer(rise, [0.4, 0.0, 0.1]))
    lt.DMP().fit([shown]).save("reach.npz")
    assert "lengthened" not in planned("reach.npz")
    assert "lengthened" not in planned("reach.npz", "--move-goal=0.01,0,0")
    said = planned("reach.npz", "--move-goal=0.4,0,0.1")
    assert said["duration"] == pytest.approx(2.0 * 2.0 / 1.3, rel=0.02)
    assert said["lengthened"].startswith("from 2 to 3.1")
    assert "1.3 times" in said["lengthened"]
    made = np.loadtxt("motion.csv", delimiter=",", skiprows=1)
    peak = (np.linalg.norm(np.diff(made[:, 1:4], axis=0), axis=1) / np.diff(made[:, 0])).max()
    usual = (np.linalg.norm(np.diff(shown.positions, axis=0), axis=1) / np.diff(shown.times)).max()
    assert 1.25 * usual <= peak <= 1.31 * usual
    asked = planned("reach.npz", "--move-goal=0.4,0,0.1", "--duration=2")
    assert asked["duration"] == pytest.approx(2.0)
    assert "lengthened" not in asked


POST = "box:0.05,0.05,0.4@0.28,0.26,0.2"
QUERY = ("skill.npz", "--move-goal", "0.05,0,0.05", "--obstacle", POST, "-o", "motion.json")


@pytest.fixture(autouse=True)
def _there(learned, monkeypatch):
    monkeypatch.chdir(learned)


def plan(*words):
    return facts("plan", *QUERY, *words)


def check(code):
    run("retime", "motion.json", "--rate", "500", "-o", "timed.json")
    return facts("check", "timed.json", "--obstacle", POST, code=code)


def test_the_wrist_keeps_clear_of_the_post_and_the_tool_gives_way():
    said = plan()
    assert 0.005 <= said["clearance"] < 0.02
    assert 0.01 < said["tip_deviation"] < 0.1
    assert "obstacle 0 and wrist_2_link" in said["reasons"]
    found = check(code=0)
    assert found["clear"]
    assert found["nearest_obstacle"]["distance"] == pytest.approx(said["clearance"], abs=1e-4)
    assert plan("--margin", "0.03")["clearance"] >= 0.03


def test_with_tip_only_the_wrist_is_left_to_the_check():
    assert "clearance" not in plan("--tip-only")
    assert not check(code=1)["clear"]


@pytest.mark.parametrize("option", [("--margin", "0.01"), ("--tip-only",)])
def test_options_for_obstacles_need_one(option):
    run("plan", "skill.npz", "-o", "motion.json", *option, code=2)
