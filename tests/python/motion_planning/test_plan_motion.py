"""Motions of skills with which the whole arm keeps clear."""

from types import SimpleNamespace

import numpy as np
import pytest
from kinds import kind
from motion_planning.conftest import DOWN, across
from refusals import refused
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput
from leadthrough.motion_planning.blocked_segment import BlockedSegment, CollisionFreeIk
from leadthrough.motion_planning.tip_paths import detours

QUERY = lt.Query(dt=0.02)


@pytest.fixture(scope="module")
def shown():
    """Three reaches beside each other."""
    return [across(height=0.1 + a) for a in (-0.01, 0.0, 0.01)]


@pytest.fixture(scope="module")
def skill(shown):
    return lt.DMP().fit(shown)


@pytest.mark.parametrize(
    "learner",
    [kind("DMP", "poses"), kind("ProMP", "poses"), kind("FastMarching", "poses", resolution=0.02)],
    ids=str,
)
def test_the_tip_gives_way_where_the_arm_has_no_room(learner, panda, shown, box):
    skill = learner.build().fit(shown)
    query = {"dt": 0.02}
    if "obstacles" in skill.supports:
        query["obstacles"] = [box]
    alone = skill.generate(**query)
    assert box.distance(alone.positions).min() > 0.0
    assert not panda.check(panda.follow(alone), [box]).ok
    planned = lt.plan_motion(skill, panda, [box], QUERY)
    report = panda.check(planned.joints, [box])
    assert report.ok
    assert planned.clearance == report.obstacles.minimum_distance
    assert panda.path_report(planned.joints, planned.tip).position_error.max() < 1e-5
    away = KDTree(alone.positions).query(planned.tip.positions)[0].max()
    assert planned.deviation == pytest.approx(away)
    assert 0.01 < planned.deviation < 0.25
    assert planned.rounds == len(planned.reasons) + 1 > 1
    assert "obstacle 0 and panda_" in planned.reasons[0]
    for end in (0, -1):
        np.testing.assert_allclose(planned.tip.positions[end], alone.positions[end], atol=1e-9)


def test_what_is_closed_is_one_shape_a_round(panda, shown):
    """A map asks each of its obstacles for distances: hundreds of balls took it a minute."""
    skill = lt.FastMarching(resolution=0.02).fit(shown)
    tall = lt.Box([0.1, 0.1, 0.45], [0.45, 0.0, 0.225])
    asked = []

    def generate(obstacles=(), **query):
        asked.append(obstacles)
        return skill.generate(obstacles=obstacles, **query)

    watched = SimpleNamespace(supports=skill.supports, generate=generate, map_with=skill.map_with)
    planned = lt.plan_motion(watched, panda, [tall], QUERY)
    assert planned.rounds > 1
    assert [len(shapes) for shapes in asked] == list(range(1, planned.rounds + 1))


def test_nothing_changes_where_the_arm_can_follow(panda, skill):
    aside = lt.Sphere(0.1, [-0.6, 0.0, 0.5])
    for obstacles in ([], [aside]):
        alone = panda.follow(skill.generate(obstacles=obstacles, dt=0.02))
        planned = lt.plan_motion(skill, panda, obstacles, QUERY)
        np.testing.assert_array_equal(planned.joints.positions, alone.positions)
        assert (planned.deviation, planned.reasons, planned.rounds) == (0.0, (), 1)
    assert lt.plan_motion(skill, panda, query=QUERY).clearance == np.inf


def test_a_skill_of_joints_goes_around_in_the_shown_posture(panda, shown, box):
    skill = lt.ProMP().fit([panda.follow(motion) for motion in shown])
    alone = skill.generate(dt=0.04)
    assert not panda.check(alone, [box]).ok
    planned = lt.plan_motion(skill, panda, [box], lt.Query(dt=0.04))
    assert panda.check(planned.joints, [box]).ok
    assert np.abs(planned.joints.positions[0] - alone.positions[0]).max() < 0.05


def test_the_answer_has_the_same_bits_each_time(panda, skill, box):
    once, again = (lt.plan_motion(skill, panda, [box], QUERY) for _ in range(2))
    np.testing.assert_array_equal(once.joints.positions, again.joints.positions)


def test_where_the_arm_cannot_stand_at_an_end_it_says_so(panda, skill, roof):
    says = r"obstacle 0 and .*no collision-free configuration .* goal"
    with pytest.raises(IkFailure, match=says):
        lt.plan_motion(skill, panda, [roof], QUERY)


def test_the_rounds_are_the_callers(panda, skill, box):
    with pytest.raises(IkFailure, match="blocked") as failure:
        lt.plan_motion(skill, panda, [box], QUERY, rounds=1)
    assert failure.value.status == "blocked"


def test_wrong_arguments_are_refused(panda, skill, box):
    refused("rounds", lt.plan_motion, skill, panda, rounds=0)
    refused("margin", lt.plan_motion, skill, panda, lt.Scene([box], -0.01))
    with pytest.raises(InvalidInput, match="query: expected a Query"):
        lt.plan_motion(skill, panda, [box], {"goal": (0.4, 0.0, 0.4)})
    refused(r"arm: expected an Arm, got None", lt.plan_motion, skill, None)
    for name, value in (("duration", np.nan), ("duration", 0.0), ("dt", -0.1)):
        refused(f"{name}: expected", lt.Query, **{name: value})


def test_an_arm_of_five_joints_stands_where_it_has_to_turn_its_tool(panda, shown):
    """It cannot tilt the tool sideways, as shown, anywhere; at start and goal nothing is near."""
    arm = panda.lock_joints({"panda_joint3": 0.0, "panda_joint5": 0.0})
    tilted = lt.rotations.compose(DOWN[None], lt.rotations.exp([[0.0, 0.2, 0.0]]))
    motion = lt.PoseTrajectory(shown[1].times, shown[1].positions, np.tile(tilted, (61, 1)))
    skill = lt.DMP().fit([motion])
    aside = lt.plan_motion(skill, arm, [lt.Sphere(0.05, [0.6, 0.0, 0.42])], QUERY)
    report = arm.path_report(aside.joints, aside.tip)
    assert report.position_error.max() < 1e-5
    assert 0.1 < report.orientation_error.max() < 0.2
    with pytest.raises(IkFailure, match=r"obstacle 0 and panda_hand$"):
        lt.plan_motion(skill, arm, [lt.Sphere(0.03, [0.5, 0.0, 0.4])], QUERY, rounds=3)


def test_without_obstacles_the_tip_keeps_its_path_or_it_fails(panda):
    """From this posture the arm would have to jump, and no obstacle is the reason."""
    rng = np.random.default_rng(0)
    lower, upper = panda.limits.lower, panda.limits.upper
    times = np.linspace(0.0, 6.0, 301)
    for _ in range(85):  # the last of them is hard
        way = rng.uniform(lower + 0.1, upper - 0.1, (4, 7))
    joints = np.clip(CubicSpline(np.linspace(0.0, 6.0, 4), way)(times), lower + 0.01, upper - 0.01)
    tip = lt.PoseTrajectory(times, *panda.forward_kinematics(joints))
    skill = SimpleNamespace(supports=frozenset(), generate=lambda **_: tip)
    with pytest.raises(IkFailure, match="jump") as alone:
        panda.follow(tip, q0=joints[0])
    with pytest.raises(IkFailure) as planned:
        lt.plan_motion(skill, panda, q0=joints[0])
    assert str(planned.value) == str(alone.value)


def test_a_part_where_the_tip_still_stands_is_not_moved_aside(panda, shown):
    motion = shown[1]
    waiting = lt.PoseTrajectory(
        motion.times,
        np.vstack([np.tile(motion.positions[0], (20, 1)), motion.positions[:41]]),
        motion.orientations,
    )
    ik = CollisionFreeIk(panda, lt.Scene(), ())
    places = np.array([0, 10, 30, 60])
    near = panda.follow(motion).positions[0]
    assert list(detours(ik, waiting, BlockedSegment(places, 1, 1), near)) == []
    beside = next(detours(ik, waiting, BlockedSegment(places, 2, 2), near))
    np.testing.assert_array_equal(beside.positions[:20], waiting.positions[:20])
    assert np.isfinite(beside.positions).all()
