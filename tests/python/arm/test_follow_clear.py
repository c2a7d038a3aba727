"""Following a path of the tip with the whole arm clear of obstacles."""

import numpy as np
import pytest
from refusals import refused
from scipy.interpolate import CubicSpline

import leadthrough as lt
from leadthrough.arm import FollowOptions, IkOptions
from leadthrough.errors import IkFailure, InvalidInput
from leadthrough_studies.coal_arm import CoalArm

MARGIN = 0.005
DOWN = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def freely(panda, sweep):
    return panda.follow(sweep)


def elbow(panda, q):
    """Position of the fourth joint, by the two parts of the chain."""
    upper = lt.Arm.load("panda", tip="panda_link4")
    return upper.forward_kinematics(q[:4])[0]


@pytest.fixture(scope="module")
def trap(panda, freely):
    """A ball where the elbow is at half time, far from the tip."""
    return lt.Sphere(0.08, elbow(panda, freely.positions[40]))


def test_the_elbow_goes_around_and_the_tip_stays(panda, sweep, freely, trap):
    assert panda.check(freely, [trap]).minimum_distance < -0.05
    around = panda.follow(sweep, scene=[trap])
    assert panda.check(around, [trap]).ok
    report = panda.path_report(around, sweep)
    assert report.position_error.max() < 1e-5
    assert report.orientation_error.max() < 1e-5
    assert np.abs(np.diff(around.positions, axis=0)).max() < 0.1


def test_what_is_clear_anyway_stays_as_it_is(panda, sweep, freely):
    aside = lt.Box([0.1, 0.1, 0.1], [-0.6, 0.0, 0.6])
    np.testing.assert_array_equal(panda.follow(sweep, scene=[aside]).positions, freely.positions)


def test_where_there_is_no_room_the_bodies_are_named(panda, sweep):
    wall = lt.Box([0.05, 0.02, 0.6], [0.45, 0.0, 0.35])  # across the tip's own path
    with pytest.raises(IkFailure, match=r"sample \d+ at .* s: blocked, .*obstacle 0") as failure:
        panda.follow(sweep, scene=[wall])
    assert failure.value.status == "blocked"
    assert 10 < failure.value.index < 40  # of 81: the hand is 20 cm wide
    assert panda.is_clear(failure.value.q, [wall])


def across_a_ur3():
    """A UR3 and poses, which point down, across in front of it."""
    share = np.linspace(0.0, 1.0, 41)[:, None]
    way = [-0.25, -0.15, 0.2] + share * [0.0, 0.3, 0.0]
    return lt.Arm.load("ur3"), lt.PoseTrajectory(2.0 * share[:, 0], way, [DOWN] * 41)


def test_a_free_axis_of_the_tool_makes_room_for_an_arm_of_six_joints():
    arm, motion = across_a_ur3()
    freely = arm.follow(motion, options=FollowOptions(free=("rz",)))
    wrist = lt.Arm.load("ur3", tip="wrist_2_link")
    there, _ = wrist.forward_kinematics(freely.positions[20, :5])
    ball = lt.Sphere(0.04, there + np.array([0.0, 0.0, 0.03]))
    assert not arm.check(freely, [ball]).ok
    around = arm.follow(motion, scene=[ball], options=FollowOptions(free=("rz",)))
    assert arm.check(around, [ball]).ok
    reached, _ = arm.forward_kinematics(around.positions)
    np.testing.assert_allclose(reached, motion.positions, atol=1e-5)


@pytest.mark.parametrize("on_rate_limit", ["deviate", "raise"])
def test_times_and_obstacles_are_not_both_kept(panda, sweep, trap, on_rate_limit):
    deviation = (0.01, 0.1) if on_rate_limit == "deviate" else None
    with pytest.raises(InvalidInput, match="scene: not used together with on_rate_limit"):
        panda.follow(sweep, scene=[trap], on_rate_limit=on_rate_limit, deviation=deviation)


# Positions of published paths among boxes before a Panda whose tip is its hand (TORM, CppFlow): the
# offset of the path, the size of the boxes and their centres, m, and the largest step of a joint.
AMONG_BOXES = {
    "1cube": (
        (0.0, 0.5421984559194368, 0.7885155964931997),
        (0.25, 0.25, 0.25),
        [(0.0, 0.2, 0.7)],
        0.05,
    ),
    "2cubes": ((0.0, 0.54, 0.79), (0.15, 0.15, 0.15), [(0.2, 0.3, 0.4), (-0.25, 0.3, 0.75)], 0.05),
    "flappy_bird": (
        (0.0, 0.54, 0.79),
        (0.05, 0.15, 0.3),
        [(0.0, 0.25, 1.0), (0.0, 0.25, 0.5)],
        0.15,
    ),
}


def published(recordings, name, offset, turn=(1.0, 0.0, 0.0, 0.0)):
    """A path, each of whose poses is turned where it is; their README's matrix turns no places."""
    rows = np.loadtxt(recordings / "tip_paths" / f"{name}.csv", delimiter=",", skiprows=1)[:, -7:]
    turns = rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    orientations = lt.rotations.compose(np.tile(turn, (len(rows), 1)), turns)
    return lt.PoseTrajectory(0.02 * np.arange(len(rows)), rows[:, :3] + offset, orientations)


@pytest.mark.parametrize("name", AMONG_BOXES)
def test_published_paths_among_boxes_are_followed(name, recordings):
    offset, size, centres, largest_step = AMONG_BOXES[name]
    motion = published(recordings, name, offset)
    boxes = [lt.Box(size, centre) for centre in centres]
    arm = lt.Arm.load("panda", tip="panda_hand")
    around = arm.follow(motion, scene=boxes)
    assert arm.check(around, boxes).ok
    report = arm.path_report(around, motion)
    assert report.position_error.max() < 1e-4
    assert report.orientation_error.max() < np.radians(0.1)
    assert np.abs(np.diff(around.positions, axis=0)).max() < largest_step
    assert least_in_coal(around.positions[::5], boxes) > MARGIN - 1e-6


@pytest.mark.parametrize("obstacles", [(), (lt.Sphere(0.05, [-0.8, 0.0, 0.3]),)])
def test_a_published_path_that_leaves_the_reach_is_refused_there(recordings, obstacles):
    """ "square": no configuration reaches samples 153 to 181."""
    quarter = np.sqrt(0.5)
    motion = published(recordings, "square", (0.75, 0.0, 0.5), (quarter, 0.0, quarter, 0.0))
    arm = lt.Arm.load("panda", tip="panda_hand")
    seeds = np.random.default_rng(0).uniform(arm.limits.lower, arm.limits.upper, (100, 7))
    reached = []
    for i in (150, 153, 167, 181, 184):
        found = arm.inverse_kinematics_batch(
            np.tile(motion.positions[i], (100, 1)),
            np.tile(motion.orientations[i], (100, 1)),
            q0=seeds,
            options=IkOptions(max_restarts=0, position_tolerance=1e-5, orientation_tolerance=1e-5),
        )
        reached.append(bool(found.success.any()))
    assert reached == [True, False, False, False, True]
    with pytest.raises(IkFailure, match=r"limits .*panda_joint5 at its lower limit") as failure:
        arm.follow(motion, scene=obstacles)
    assert 153 <= failure.value.index <= 156
    assert failure.value.status == "limits"
    assert "panda_joint5" in failure.value.limiting_joints


def least_in_coal(q, boxes):
    peer = CoalArm(lt.Arm.load("panda"))
    boxes = [peer.solid(box) for box in boxes]
    least = np.inf
    for row in q:
        peer.place(row)
        least = min(least, *(peer.distance_to(peer.moving_links(), *box) for box in boxes))
    return least


def test_paths_that_joints_can_take_are_followed(panda):
    """Without looking ahead, 5 of these 60 end where a joint limit stands in the way."""
    rng = np.random.default_rng(0)
    middle = 0.5 * (panda.limits.lower + panda.limits.upper)
    widest = 0.35 * (panda.limits.upper - panda.limits.lower)
    times = np.linspace(0.0, 6.0, 301)
    for _ in range(60):
        way = middle + widest * rng.uniform(-1.0, 1.0, (4, 7))
        joints = CubicSpline(np.linspace(0.0, 6.0, 4), way)(times)
        joints = np.clip(joints, panda.limits.lower, panda.limits.upper)
        tip = lt.PoseTrajectory(times, *panda.forward_kinematics(joints))
        followed = panda.follow(tip, q0=joints[0])
        report = panda.path_report(followed, tip)
        assert report.position_error.max() < 1e-5
        assert np.abs(np.diff(followed.positions, axis=0)).max() < 0.5


TOP = 0.35  # m, of a post in the way of the hand


@pytest.fixture(scope="module")
def post():
    return lt.Box([0.06, 0.06, 0.06], [0.45, 0.0, TOP - 0.03])


@pytest.fixture(scope="module")
def lifted(panda, sweep, post):
    return panda.follow(sweep, scene=[post], deviation=((0.0, 0.0, 0.04), 0.0))


def test_the_tip_gives_way_by_what_is_needed_and_no_more(panda, sweep, post, lifted):
    with pytest.raises(IkFailure, match="no room between obstacle 0 and panda_hand"):
        panda.follow(sweep, scene=[post])
    peer = CoalArm(panda)
    peer.place(panda.follow(sweep).positions[40])
    lower = lt.Box(post.size, post.position - [0.0, 0.0, 0.1])
    over = 0.1 - peer.distance_to(["panda_hand"], *peer.solid(lower))
    found, _ = panda.forward_kinematics(lifted.positions)
    rise = (found - sweep.positions)[:, 2]
    assert over + MARGIN < rise.max() < over + MARGIN + 0.003
    assert np.abs((found - sweep.positions)[:, :2]).max() < 1e-5
    np.testing.assert_allclose(found[[0, -1]], sweep.positions[[0, -1]], atol=1e-5)
    assert np.abs(rise[[1, 2, -3, -2]]).max() < 2e-3
    assert panda.check(lifted, [post]).ok
    report = panda.path_report(lifted, sweep)
    assert report.orientation_error.max() < 1e-5
    assert report.position_error.max() == pytest.approx(rise.max(), rel=1e-3)


def test_it_leaves_its_path_and_comes_back_smoothly(lifted):
    assert np.abs(np.diff(lifted.positions, 2, axis=0)).max() < 0.003


def test_coal_finds_the_arm_clear(lifted, post):
    assert least_in_coal(lifted.positions, [post]) > MARGIN - 1e-6


def test_matrices_in_the_base_frame_say_the_same(panda, sweep, post, lifted):
    upwards = np.tile(np.diag([0.0, 0.0, 0.04**2]), (81, 1, 1))
    again = panda.follow(sweep, scene=[post], deviation=(upwards, 0.0))
    np.testing.assert_array_equal(again.positions, lifted.positions)


@pytest.mark.parametrize("room", [(0.03, 0.0), (0.03, 0.1), ((0.05, 0.001, 0.03), (0.2, 0.0, 0.0))])
def test_all_samples_are_within_the_ellipsoid(panda, sweep, post, room):
    joints = panda.follow(sweep, scene=[post], deviation=room)
    assert panda.check(joints, [post]).ok
    positions, orientations = panda.forward_kinematics(joints.positions)
    back = lt.rotations.to_matrix(sweep.orientations).transpose(0, 2, 1)
    along = np.einsum("nij,nj->ni", back, positions - sweep.positions)
    turned = lt.rotations.to_matrix(orientations)
    about = lt.rotations.log(lt.rotations.from_matrix(back @ turned))
    lengths, angles = (np.maximum(np.broadcast_to(each, 3), 1e-5) for each in room)
    used = ((along / lengths) ** 2).sum(axis=1) + ((about / angles) ** 2).sum(axis=1)
    assert 0.1 < used.max() < 1.03


def test_what_is_not_enough_is_refused(panda, sweep, post):
    higher = lt.Box(post.size, np.add(post.position, [0.0, 0.0, 0.03]))
    with pytest.raises(IkFailure, match=r"blocked, .*obstacle 0") as failure:
        panda.follow(sweep, scene=[higher], deviation=(0.02, 0.0))
    assert 10 < failure.value.index < 40


def test_the_path_is_kept_where_the_arm_can(panda, sweep, trap):
    around = panda.follow(sweep, scene=[trap])
    roomy = panda.follow(sweep, scene=[trap], deviation=(0.05, 0.5))
    np.testing.assert_array_equal(roomy.positions, around.positions)


def test_an_axis_left_free_stays_free_beside_the_path():
    arm, motion = across_a_ur3()
    post = lt.Box([0.04, 0.04, 0.1], [-0.25, 0.0, 0.155])
    with pytest.raises(IkFailure, match="obstacle 0"):
        arm.follow(motion, scene=[post], options=FollowOptions(free=("rz",)))
    joints = arm.follow(
        motion, scene=[post], options=FollowOptions(free=("rz",)), deviation=(0.04, 0.0)
    )
    assert arm.check(joints, [post]).ok
    positions, orientations = arm.forward_kinematics(joints.positions)
    assert 0.005 < np.linalg.norm(positions - motion.positions, axis=1).max() < 0.04
    axis = lt.rotations.to_matrix(orientations)[:, :, 2]
    np.testing.assert_allclose(axis, np.tile([0.0, 0.0, -1.0], (41, 1)), atol=1e-5)


def test_wrong_room_is_refused(panda, sweep, post):
    for deviation, message in [
        (0.1, r"expected the room in m and in rad, \(m, rad\), got 0.1"),
        ((0.1,), "expected the room in m and in rad"),
        ((-0.1, 0.0), "deviation in m"),
        ((0.1, np.nan), "deviation in rad"),
        (((0.1, -0.1, 0.1), 0.0), "deviation in m: expected numbers >= 0"),
        ((0.1, (0.1, 0.1)), "deviation in rad"),
        ((np.tile(-np.eye(3), (81, 1, 1)), 0.0), "deviation in m: expected covariances"),
        ((np.tile(np.eye(3), (80, 1, 1)), 0.0), "deviation in m"),
    ]:
        refused(message, panda.follow, sweep, scene=[post], deviation=deviation)
    refused("deviation: only used with a scene", panda.follow, sweep, deviation=(0.1, 0.1))
