"""Following a path of the tip with room beside it: no more than stated, and only where needed."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput
from leadthrough_studies.coal_arm import CoalArm

MARGIN = 0.005
DOWN = [0.0, 1.0, 0.0, 0.0]
TOP = 0.35  # m, of a post in the way of the hand


@pytest.fixture(scope="module")
def panda():
    return lt.Arm.load("panda")


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


def test_coal_finds_the_arm_clear(lifted, panda, post):
    peer = CoalArm(panda)
    for q in lifted.positions:
        peer.place(q)
        assert peer.distance_to(peer.moving_links(), *peer.solid(post)) > MARGIN - 1e-6


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


def test_the_path_is_kept_where_the_arm_can(panda, sweep):
    q = panda.follow(sweep).positions[40]
    elbow, _ = lt.Arm.load("panda", tip="panda_link4").forward_kinematics(q[:4])
    trap = lt.Sphere(0.08, elbow)
    around = panda.follow(sweep, scene=[trap])
    roomy = panda.follow(sweep, scene=[trap], deviation=(0.05, 0.5))
    np.testing.assert_array_equal(roomy.positions, around.positions)


def test_an_axis_left_free_stays_free_beside_the_path():
    arm = lt.Arm.load("ur3")
    share = np.linspace(0.0, 1.0, 41)[:, None]
    way = [-0.25, -0.15, 0.2] + share * [0.0, 0.3, 0.0]
    motion = lt.PoseTrajectory(2.0 * share[:, 0], way, np.tile(DOWN, (41, 1)))
    post = lt.Box([0.04, 0.04, 0.1], [-0.25, 0.0, 0.155])
    with pytest.raises(IkFailure, match="obstacle 0"):
        arm.follow(motion, scene=[post], options=lt.arm.FollowOptions(free=("rz",)))
    joints = arm.follow(
        motion, scene=[post], options=lt.arm.FollowOptions(free=("rz",)), deviation=(0.04, 0.0)
    )
    assert arm.check(joints, [post]).ok
    positions, orientations = arm.forward_kinematics(joints.positions)
    assert 0.005 < np.linalg.norm(positions - way, axis=1).max() < 0.04
    axis = lt.rotations.to_matrix(orientations)[:, :, 2]
    np.testing.assert_allclose(axis, np.tile([0.0, 0.0, -1.0], (41, 1)), atol=1e-5)


@pytest.mark.parametrize(
    ("deviation", "message"),
    [
        (0.1, r"expected the room in m and in rad, \(m, rad\), got 0.1"),
        ((0.1,), "expected the room in m and in rad"),
        ((-0.1, 0.0), "deviation in m"),
        ((0.1, np.nan), "deviation in rad"),
        (((0.1, -0.1, 0.1), 0.0), "deviation in m: expected numbers >= 0"),
        ((0.1, (0.1, 0.1)), "deviation in rad"),
        ((np.tile(-np.eye(3), (81, 1, 1)), 0.0), "deviation in m: expected covariances"),
        ((np.tile(np.eye(3), (80, 1, 1)), 0.0), "deviation in m"),
    ],
)
def test_wrong_room_is_refused(panda, sweep, post, deviation, message):
    with pytest.raises(InvalidInput, match=message):
        panda.follow(sweep, scene=[post], deviation=deviation)


def test_without_obstacles_it_is_refused(panda, sweep):
    with pytest.raises(InvalidInput, match="deviation: only used with a scene"):
        panda.follow(sweep, deviation=(0.1, 0.1))
