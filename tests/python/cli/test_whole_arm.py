"""`leadthrough plan` with an arm and obstacles: the whole arm keeps clear."""

import pytest
from cli.command_line import facts, run

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
