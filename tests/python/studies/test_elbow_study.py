"""Obstacles in the way of the elbow: solutions are clear by another library's measure too."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough_studies.elbow.recheck import rechecked
from leadthrough_studies.elbow.reference import Roadmap
from leadthrough_studies.elbow.scenes import FREE, MARGIN, drawn_scene
from leadthrough_studies.elbow.study import STUDY, ElbowConfig, trap
from leadthrough_studies.study import run, selected


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    config = ElbowConfig(scenes=12, searched=False, connected=False)
    return run(STUDY, config, out=tmp_path_factory.mktemp("elbow"))


def test_scenes_that_can_be_solved_are(outcome):
    assert not outcome.failures
    for row in outcome.report.table[:2]:
        assert row["touch_without"] == row["scenes"] == 12
        assert row["clear"] == row["solved"] >= 2
        assert row["least_distance_m"] >= MARGIN
        assert row["most_tip_error_m"] < 1e-5
        assert row["asked_of_connect"] == row["solved_by_the_search_alone"] == 0
        assert row["share_of_solvable"] == 1.0
    panda, ur3, both = outcome.report.table
    assert panda["solved"] == panda["possible"]
    assert both["solved"] == panda["solved"] + ur3["solved"]


def test_every_motion_is_looked_at_again_by_coal_between_its_samples(outcome):
    for row in outcome.report.table:
        assert row["rechecked"] == row["solved"]
        assert row["rechecked_steps"] > 10_000 * row["rechecked"]
        assert row["touches"] == 0
        assert MARGIN - 1e-5 < row["least_coal_distance_m"] < row["least_distance_m"] + 1e-3


def test_failures_name_the_time_and_what_is_in_the_way(outcome):
    failed = selected(outcome.rows, by="follow", solved=0)
    assert failed
    for row in failed:
        assert " s: " in row["failure"]
        assert "blocked" in row["failure"] or "jump" in row["failure"]


def test_the_slow_search_and_rrt_connect_are_asked(outcome):
    """The search where the arm can stand but `follow` has no way, which is none of these scenes."""
    config = ElbowConfig(arms=("panda",), scenes=3)
    asked = [task for task in STUDY.tasks(config) if task.function not in {trap, rechecked}]
    found = [row for task in asked for row in task.function(**task.arguments)]
    assert not selected(found, by="reference")
    own = [row for row in selected(outcome.rows, arm="panda") if row["index"] < 3]
    (row,) = STUDY.report(config, own + found).table
    assert row["solved"] == 1
    assert (row["asked_of_connect"], row["connect_solved"]) in {(3, 2), (0, 0)}  # without OMPL
    alone = {"by": "reference", "arm": "panda", "motion": "reach", "index": 1, "solved": 1}
    report = STUDY.report(config, [*own, alone | {"reference_cpu_s": 70.0}])
    assert report.table[0]["share_of_solvable"] == 0.5
    assert [each["index"] for each in report.summary["solved_by_the_search_alone"]] == [1]


def test_the_slow_search_finds_a_way_that_is_clear_or_where_it_ends():
    arm = lt.Arm.load("panda")
    made = drawn_scene(arm, "panda", 0, 2, [])
    way = Roadmap(arm, made.tip, made.obstacles, MARGIN, ()).way()
    tip, _ = arm.forward_kinematics(way)
    np.testing.assert_allclose(tip, made.tip.positions, atol=1e-5)
    assert np.abs(np.diff(way, axis=0)).max() < 0.5
    assert arm.check(way, lt.Scene(made.obstacles, MARGIN)).ok
    walled = Roadmap(arm, made.tip, (lt.Sphere(0.04, made.tip.positions[40]),), MARGIN, ())
    assert walled.way() is None
    assert 0 < walled.last < 40


# Of an arm of six joints whose tool may spin: where the nearest family of postures ends on the way
# (34), or at the goal (36), and where it touches itself by 0.2 mm between two layers (77).
@pytest.mark.parametrize("index", [34, 36, 77])
def test_another_family_of_postures_is_found(index):
    arm = lt.Arm.load("ur3")
    made = drawn_scene(arm, "ur3", 0, index, [])
    first = made.joints.positions[0]
    joints = arm.follow(
        made.tip, scene=made.obstacles, q0=first, options=lt.arm.FollowOptions(free=FREE["ur3"])
    )
    assert arm.check(joints, lt.Scene(made.obstacles, MARGIN)).ok
    assert np.abs(joints.positions[0] - first).max() > 1.0


def test_where_the_nearest_family_is_too_narrow_another_is_taken():
    """Near the first posture, the forearm would pass 4.6 mm beside an obstacle at best."""
    arm = lt.Arm.load("panda")
    made = drawn_scene(arm, "panda", 0, 123, [])
    first = made.joints.positions[0]
    joints = arm.follow(made.tip, scene=made.obstacles, q0=first)
    assert arm.check(joints, lt.Scene(made.obstacles, MARGIN)).ok


def test_demonstrations_by_hand_are_followed(recordings):
    files = sorted(str(file) for file in (recordings / "robotasks").glob("*.npy"))
    arm = lt.Arm.load("panda")
    made = drawn_scene(arm, "panda", 0, 2, files)
    assert not arm.check(made.joints, made.obstacles).ok
    joints = arm.follow(made.tip, scene=made.obstacles, q0=made.joints.positions[0])
    assert arm.check(joints, lt.Scene(made.obstacles, MARGIN)).ok
    assert arm.path_report(joints, made.tip).position_error.max() < 1e-5
