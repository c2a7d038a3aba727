"""Obstacles in the way of the elbow: what is solved is clear by another library's measure too."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from arm.coal_arm import CoalArm

import leadthrough as lt
from leadthrough_studies.elbow.reference import Roadmap
from leadthrough_studies.elbow.scenes import FREE, MARGIN, drawn_scene, scene
from leadthrough_studies.elbow.study import STUDY, ElbowConfig
from leadthrough_studies.study import run, selected


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    config = ElbowConfig(scenes=12, compared=0)
    return run(STUDY, config, out=tmp_path_factory.mktemp("elbow"), jobs=1)


def test_scenes_that_can_be_solved_are(outcome):
    assert not outcome.failures
    for row in outcome.report.table:
        assert row["touch_without"] == row["scenes"] == 12
        assert row["clear"] == row["solved"] >= 2
        assert row["least_distance_m"] >= MARGIN
        assert row["most_tip_error_m"] < 1e-5
    panda = outcome.report.table[0]
    assert panda["solved"] == panda["possible"]


def test_failures_name_the_time_and_what_is_in_the_way(outcome):
    failed = selected(outcome.rows, by="follow", solved=0)
    assert failed
    for row in failed:
        assert " s: " in row["failure"]
        assert "blocked" in row["failure"] or "jump" in row["failure"]


def test_what_the_slow_search_solves_is_solved():
    config = ElbowConfig(arms=("panda",), scenes=3, compared=3)
    asked = STUDY.tasks(config)
    report = STUDY.report(
        config, [row for each in asked for row in each.function(**each.arguments)]
    )
    (row,) = report.table
    assert row["compared"] == 3
    assert row["both_solved"] == row["reference_solved"] == 1
    assert row["share_of_reference"] == 1.0
    assert row["connect_solved"] in {None, 2}  # without OMPL it is not asked
    assert report.summary["solved_by_the_reference_alone"] == []


def test_the_slow_search_finds_a_way_that_is_clear_or_where_it_ends():
    arm = lt.Arm.load("panda")
    made = drawn_scene(arm, "panda", 0, 2, [])
    way = Roadmap(arm, made.tip, made.obstacles, MARGIN, ()).way()
    tip, _ = arm.forward_kinematics(way)
    np.testing.assert_allclose(tip, made.tip.positions, atol=1e-5)
    assert np.abs(np.diff(way, axis=0)).max() < 0.5
    assert arm.check(way, made.obstacles, margin=MARGIN).ok
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
    joints = arm.follow(made.tip, seed=first, free=FREE["ur3"], obstacles=made.obstacles)
    assert arm.check(joints, made.obstacles, margin=MARGIN).ok
    assert np.abs(joints.positions[0] - first).max() > 1.0


def test_where_the_nearest_family_is_too_narrow_another_is_taken():
    """Near the first posture, the forearm would pass 4.6 mm beside an obstacle at best."""
    arm = lt.Arm.load("panda")
    made = drawn_scene(arm, "panda", 0, 123, [])
    first = made.joints.positions[0]
    joints = arm.follow(made.tip, seed=first, obstacles=made.obstacles)
    assert arm.check(joints, made.obstacles, margin=MARGIN).ok


def test_demonstrations_by_hand_are_followed(recordings):
    files = sorted(str(file) for file in (recordings / "robotasks").glob("*.npy"))
    arm = lt.Arm.load("panda")
    made = drawn_scene(arm, "panda", 0, 2, files)
    assert not arm.check(made.joints, made.obstacles).ok
    joints = arm.follow(made.tip, seed=made.joints.positions[0], obstacles=made.obstacles)
    assert arm.check(joints, made.obstacles, margin=MARGIN).ok
    assert arm.path_report(joints, made.tip).position_error.max() < 1e-5


@pytest.mark.parametrize("name", ["panda", "ur3"])
def test_coal_finds_no_touch(outcome, name):
    row = selected(outcome.rows, by="follow", arm=name, solved=1)[0]
    arm = lt.Arm.load(name)
    made = scene(arm, name, np.random.default_rng([0, row["index"]]))
    joints = arm.follow(
        made.tip, seed=made.joints.positions[0], free=FREE[name], obstacles=made.obstacles
    )
    peer = CoalArm(name)
    for q in joints.positions:
        peer.place(q)
        for shape in made.obstacles:
            pose = pin.SE3(np.eye(3), shape.position)
            assert peer.distance_to(peer.moving_links(), _in_coal(shape), pose) > MARGIN - 1e-5


def _in_coal(shape):
    if isinstance(shape, lt.Box):
        return coal.Box(*shape.size)
    if isinstance(shape, lt.Sphere):
        return coal.Sphere(shape.radius)
    return coal.Cylinder(shape.radius, shape.length)
