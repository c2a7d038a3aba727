"""Motions of skills with which the whole arm keeps clear."""

from types import SimpleNamespace

import numpy as np
import pytest
from kinds import kind
from motion_planning.conftest import DOWN, across
from refusals import raised, refused
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput
from leadthrough.motion_planning import connect_configurations
from leadthrough.motion_planning.tip_paths import BlockedSegment, CollisionFreeIk, detours

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


def test_an_object_in_two_hands_gives_way_and_stays_in_both(panda):
    pair = lt.DualArm(panda, panda, ((0.0, -0.8, 0.0), (1.0, 0.0, 0.0, 0.0)))
    grasps = (((0.0, 0.2, 0.0), DOWN), ((0.0, -0.2, 0.0), DOWN))
    pair = pair.with_object(lt.Box((0.08, 0.3, 0.02), (0.0, 0.0, -0.02)), grasps)
    held = lt.arm.HeldObject(pair, grasps)
    times = np.linspace(0.0, 4.0, 101)
    s = lt.trajectories.minimum_jerk_time_scaling(times / 4.0)
    path = np.column_stack([0.3 + 0.4 * s, np.full(101, -0.4), np.full(101, 0.3)])
    shown = lt.PoseTrajectory(times, path, np.tile([1.0, 0.0, 0.0, 0.0], (101, 1)))
    wall = lt.Box((0.04, 0.1, 0.3), (0.5, -0.4, 0.15))
    skill = lt.DMP().fit([shown])
    assert not held.check(held.follow(skill.generate(dt=0.04)), [wall]).ok
    planned = lt.plan_motion(skill, held, [wall], lt.Query(dt=0.04))
    assert held.check(planned.joints, [wall]).ok
    assert 0.01 < planned.deviation < 0.25
    position, _ = held.pair.relative_pose(planned.joints.positions)
    assert np.linalg.norm(position - position[0], axis=1).max() < 1e-5
    for option in ({"last_resort": "joint_space"}, {"deviation": (0.1, 0.1)}):
        with pytest.raises(InvalidInput, match="expected None for an object that two arms hold"):
            lt.plan_motion(skill, held, [wall], **option)
    joints = lt.DMP().fit([held.follow(shown)])
    again = lt.plan_motion(joints, held, query=lt.Query(dt=0.04))
    assert np.abs(again.tip.positions[-1] - path[-1]).max() < 1e-3


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
    refused("margin", lt.Scene, [box], -0.01)
    with pytest.raises(InvalidInput, match="query: expected a Query"):
        lt.plan_motion(skill, panda, [box], {"goal": (0.4, 0.0, 0.4)})
    refused(r"arm: expected an Arm, got None", lt.plan_motion, skill, None)
    no_turn = ((0.4, 0.0, 0.4), (0.0, 0.0, 0.0, 0.0))
    for name, value in (("duration", np.nan), ("duration", 0.0), ("dt", -0.1), ("goal", no_turn)):
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
    assert str(raised(IkFailure, lt.plan_motion, skill, panda, q0=joints[0])) == str(alone.value)


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


ONCE = {"query": QUERY, "rounds": 1}
LAST_RESORT = ONCE | {"last_resort": "joint_space"}


@pytest.fixture(scope="module")
def joint_skill():
    """Of a reach with the gripper closed on the way."""
    return lt.DMP().fit([across(events=[lt.Event(1.0, "close")])])


@pytest.fixture(scope="module")
def planned(panda, joint_skill, box):
    return lt.plan_motion(joint_skill, panda, [box], **LAST_RESORT)


def test_the_dead_part_is_connected_and_certified(panda, box, planned):
    report = panda.check(planned.joints, [box])
    assert report.ok
    assert planned.clearance == report.obstacles.minimum_distance
    used = panda.path_report(planned.joints, planned.tip)
    assert used.velocity_ratio.max() <= 1.0 + 1e-6
    assert used.acceleration_ratio.max() <= 1.0 + 1e-6
    timed = lt.retime(planned.joints, panda.limits, rate=250.0, path_tolerance=1e-4)
    assert lt.check_limits(timed, panda.limits).ok
    begin, end = planned.connected
    assert 0.0 < begin < end < planned.joints.duration
    assert planned.rounds == 2
    assert "obstacle 0" in planned.reasons[0]
    tip, _ = panda.forward_kinematics(planned.joints.positions)
    np.testing.assert_allclose(tip, planned.tip.positions, atol=1e-5)


def test_the_rest_of_the_path_stays_as_learned(joint_skill, box, planned):
    alone = joint_skill.generate(obstacles=[box], dt=0.02)
    times = planned.joints.times
    before = np.flatnonzero(times <= planned.connected[0])
    after = np.flatnonzero(times >= planned.connected[1])
    assert min(len(before), len(after)) > 5
    np.testing.assert_array_equal(planned.tip.positions[before], alone.positions[: len(before)])
    np.testing.assert_array_equal(planned.tip.positions[after], alone.positions[-len(after) :])


def test_events_are_kept(planned):
    assert [event.name for event in planned.joints.events] == ["close"]
    assert [event.name for event in planned.tip.events] == ["close"]


def test_the_answer_has_the_same_bits_past_a_narrow_part(panda, joint_skill, box, planned):
    again = lt.plan_motion(joint_skill, panda, [box], **LAST_RESORT)
    np.testing.assert_array_equal(again.joints.positions, planned.joints.positions)


def test_it_is_not_needed_where_the_tip_can_give_way(panda, joint_skill, box):
    usual = lt.plan_motion(joint_skill, panda, [box], QUERY)
    allowed = lt.plan_motion(joint_skill, panda, [box], QUERY, last_resort="joint_space")
    assert allowed.connected is usual.connected is None
    np.testing.assert_array_equal(allowed.joints.positions, usual.joints.positions)


def test_it_is_off_by_default_and_helps_at_no_end(panda, joint_skill, box, roof):
    assert "blocked" in str(raised(IkFailure, lt.plan_motion, joint_skill, panda, [box], **ONCE))
    refused("last_resort", lt.plan_motion, joint_skill, panda, last_resort="prayer")
    with pytest.raises(IkFailure, match="no collision-free configuration found at the goal"):
        lt.plan_motion(joint_skill, panda, [roof], QUERY, last_resort="joint_space")


def test_a_connection_is_clear_or_not_found_in_the_steps_allowed(panda):
    wall = [lt.Box([0.3, 0.02, 0.6], [0.5, 0.0, 0.3])]
    left, right = (panda.inverse_kinematics([0.5, y, 0.3], DOWN).q for y in (-0.3, 0.3))
    assert not panda.check([left, right], wall).ok
    way = connect_configurations(panda, left, right, wall)
    np.testing.assert_array_equal(way[[0, -1]], [left, right])
    assert panda.check(way, wall).ok
    assert connect_configurations(panda, left, right, wall, steps=1) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"arm": None}, "arm: expected an Arm, got None"),
        ({"start": [0.0] * 6}, "start"),
        ({"goals": [[9.0] * 7]}, "goals: expected joints inside the arm's limits"),
        ({"goals": np.zeros((0, 7))}, "goals: expected at least one configuration, got none"),
        ({"seed": -1}, "seed"),
        ({"steps": 0}, "steps"),
    ],
)
def test_wrong_arguments_of_a_connection_are_named(panda, change, message):
    q = panda.inverse_kinematics([0.5, 0.0, 0.3], DOWN).q
    refused(message, connect_configurations, **{"arm": panda, "start": q, "goals": q} | change)


ACROSS = lt.Query(dt=0.025)


@pytest.fixture(scope="module")
def pose_skill():
    """Reaches across the table, higher or lower in the middle by 4 cm, the tool pointing down."""
    bows = ((-0.002, -0.04), (0.0, 0.0), (0.002, 0.04), (0.001, -0.02), (-0.001, 0.02))
    shown = [across(side, 0.02 + height, width=0.5, low=0.33) for side, height in bows]
    return lt.ProMP(weights=8).fit(shown)


@pytest.fixture(scope="module")
def post():
    return lt.Box([0.06, 0.06, 0.2], [0.45, 0.0, 0.255])


def test_the_tip_stays_within_the_skills_own_spread(panda, pose_skill, post):
    planned = lt.plan_motion(pose_skill, panda, [post], ACROSS, standard_deviations=2.5)
    assert panda.check(planned.joints, [post]).ok
    assert planned.rounds == 2
    assert "obstacle 0" in planned.reasons[0]
    found, _ = panda.forward_kinematics(planned.joints.positions)
    np.testing.assert_allclose(found, planned.tip.positions, atol=1e-9)
    alone = pose_skill.generate(dt=0.025)
    away = found - alone.positions
    assert np.abs(away[[0, -1]]).max() < 1e-5
    assert 0.01 < np.abs(away[:, 2]).max() < 0.1
    _, covariance = pose_skill.distribution(planned.tip.times)
    inside = slice(1, -1)
    scaled = np.linalg.solve(covariance[inside, :3, :3], away[inside, :, None])
    assert np.sqrt(np.einsum("ni,nik->n", away[inside], scaled)).max() < 2.6
    assert planned.deviation <= np.linalg.norm(away, axis=1).max() + 1e-9


def test_the_tip_stays_within_what_is_stated(panda, pose_skill, post):
    planned = lt.plan_motion(pose_skill, panda, [post], ACROSS, deviation=(0.06, 0.0))
    assert panda.check(planned.joints, [post]).ok
    assert 0.01 < planned.deviation < 0.06
    assert planned.tip.times[-1] == pose_skill.generate(dt=0.025).times[-1]


def test_where_that_is_not_enough_another_path_is_made(panda, pose_skill, post):
    planned = lt.plan_motion(pose_skill, panda, [post], ACROSS, deviation=(0.005, 0.0))
    assert panda.check(planned.joints, [post]).ok
    assert planned.deviation > 0.01


def test_a_skill_without_a_covariance_is_refused(panda, pose_skill):
    shown = lt.Demonstration(pose_skill.generate(dt=0.05))
    for other in (lt.DMP().fit([shown]), lt.ProMP().fit([panda.follow(shown.motion)])):
        with pytest.raises(InvalidInput, match="standard_deviations: this skill has no covariance"):
            lt.plan_motion(other, panda, standard_deviations=2.0)
    refused("standard_deviations", lt.plan_motion, pose_skill, panda, standard_deviations=0.0)
    with pytest.raises(InvalidInput, match="deviation: not used together with standard_deviations"):
        lt.plan_motion(pose_skill, panda, standard_deviations=2.0, deviation=(0.1, 0.0))


# Configuration, length of the sweep and offset of the obstacle from its middle, m.
STARTS = {
    "panda": ([0.0, -0.5, 0.0, -2.2, 0.0, 1.8, 0.8], 0.35, (0.0, 0.0, 0.07)),
    "ur3": ([0.0, -1.2, 1.4, -1.7, -1.5, 0.3], 0.25, (0.08, 0.0, 0.0)),
    "tiago": ([0.15, 0.6, 0.2, -1.0, 1.4, 0.0, 0.3, 0.0], 0.2, (0.0, 0.0, 0.07)),
}
SHAPES = {
    "sphere": lambda middle: [lt.Sphere(0.04, middle)],
    "boxes": lambda middle: [
        lt.Box((0.06, 0.06, 0.06), middle),
        lt.Box((0.1, 0.1, 0.1), np.add(middle, (0.0, 0.0, 0.3))),
    ],
    "cloud": lambda middle: [
        lt.PointCloud(0.02 * np.random.default_rng(0).normal(size=(50, 3)) + middle, 0.01)
    ],
}


def sweep(arm, name):
    """A motion of the tip, sideways along y."""
    q, reach, _ = STARTS[name]
    position, orientation = arm.forward_kinematics(np.array(q))
    phase = np.linspace(0.0, 1.0, 41)
    rise = lt.trajectories.minimum_jerk_time_scaling(phase)[:, None]
    line = position + (rise - 0.5) * [0.0, reach, 0.0]
    return lt.PoseTrajectory(3.0 * phase, line, np.tile(orientation, (41, 1))), np.array(q)


@pytest.mark.parametrize("margin", [0.0, 0.005, 0.01])
@pytest.mark.parametrize("shapes", SHAPES)
@pytest.mark.parametrize("name", STARTS)
def test_planned_motion_passes_check_with_same_scene(name, shapes, margin):
    arm = lt.Arm.load(name)
    motion, q0 = sweep(arm, name)
    beside = motion.positions[20] + STARTS[name][2]
    scene = lt.Scene(SHAPES[shapes](beside), margin)
    skill = lt.DMP().fit([motion])
    joints = lt.plan_motion(skill, arm, scene, lt.Query(dt=0.05), q0=q0).joints
    assert arm.check(joints, scene).ok
    assert arm.check(joints, scene, tolerance=1e-4).ok
    timed = lt.retime(joints, arm.limits, rate=250.0)
    report = arm.check(timed, scene)
    assert report.ok, str(report)
