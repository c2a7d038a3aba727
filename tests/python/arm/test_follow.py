import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput

TIMES = np.linspace(0.0, 4.0, 400)


def loop(arm, posture, size=0.05):
    """Poses on a smooth loop near a posture, the tool rocking a little."""
    position, orientation = arm.forward_kinematics(posture)
    offsets = np.stack(
        [np.sin(2 * TIMES) * np.cos(TIMES), np.cos(2 * TIMES) - 1, np.sin(TIMES)], axis=1
    )
    rocking = np.zeros((len(TIMES), 3))
    rocking[:, 0] = 0.2 * np.sin(TIMES)
    turned = lt.rotations.compose(lt.rotations.exp(rocking), np.tile(orientation, (len(TIMES), 1)))
    return lt.PoseTrajectory(TIMES, position + size * offsets, turned)


def assert_follows(arm, motion, joints):
    reached, turned = arm.forward_kinematics(joints.positions)
    assert np.linalg.norm(reached - motion.positions, axis=1).max() < 1e-5
    if isinstance(motion, lt.PoseTrajectory):
        assert lt.rotations.distance(turned, motion.orientations).max() < 1e-5
    assert (joints.positions >= arm.limits.lower).all()
    assert (joints.positions <= arm.limits.upper).all()


@pytest.mark.parametrize("seeded", [True, False])
def test_a_smooth_path_is_followed_without_a_jump(arm, posture, seeded):
    motion = loop(arm, posture)
    seed = posture if seeded else None
    joints = arm.follow(motion, q0=seed, on_rate_limit="exceed_limits")
    assert_follows(arm, motion, joints)
    assert np.abs(np.diff(joints.positions, axis=0)).max() < 0.05
    assert joints.joint_names == arm.joint_names
    np.testing.assert_array_equal(joints.times, motion.times)


def test_points_leave_the_orientation_free(arm, posture):
    poses = loop(arm, posture)
    motion = lt.Trajectory(poses.times, poses.positions)
    joints = arm.follow(motion)
    assert_follows(arm, motion, joints)


def test_a_seed_keeps_its_posture(arm, posture):
    joints = arm.follow(
        loop(arm, posture), q0=posture, options=lt.arm.FollowOptions(nullspace_gain=0.0)
    )
    np.testing.assert_allclose(joints.positions[0], posture, atol=1e-4)


def test_velocities_are_the_positions_derivative(arm, posture):
    motion = loop(arm, posture)
    joints = arm.follow(motion, q0=posture, on_rate_limit="exceed_limits")
    steps = np.trapezoid(joints.velocities, TIMES, axis=0)
    np.testing.assert_allclose(steps, joints.positions[-1] - joints.positions[0], atol=1e-3)
    assert joints.accelerations is None


def test_the_pull_moves_a_redundant_arm_and_not_the_tool(arm, posture):
    motion = loop(arm, posture, size=0.0)
    still = lt.PoseTrajectory(TIMES, motion.positions, np.tile(motion.orientations[0], (400, 1)))
    joints = arm.follow(still, q0=posture, options=lt.arm.FollowOptions(nullspace_gain=0.5))
    reached, _ = arm.forward_kinematics(joints.positions)
    assert np.linalg.norm(reached - still.positions, axis=1).max() < 1.1e-6
    middle = 0.5 * (arm.limits.lower + arm.limits.upper)
    away = np.linalg.norm(joints.positions - middle, axis=1)
    if len(posture) > 6:
        assert (np.diff(away) < 1e-9).all()
        assert away[-1] < away[0] - 0.01
    else:
        np.testing.assert_allclose(joints.positions, np.tile(posture, (400, 1)), atol=1e-9)


def test_a_motion_that_is_too_fast_is_followed_and_left_to_be_slowed(arm, posture):
    motion = loop(arm, posture)
    fast = lt.PoseTrajectory(TIMES / 100, motion.positions, motion.orientations)
    joints = arm.follow(fast, q0=posture, on_rate_limit="exceed_limits")
    assert_follows(arm, fast, joints)
    np.testing.assert_array_equal(joints.times, fast.times)
    assert (np.abs(joints.velocities) > arm.limits.velocity).any()
    with pytest.raises(IkFailure) as failure:
        arm.follow(fast, q0=posture, on_rate_limit="raise")
    assert failure.value.status == "too_fast"


def test_unless_told_otherwise_a_motion_that_is_too_fast_is_slowed_and_every_step_bounded(
    arm, posture
):
    motion = loop(arm, posture)
    fast = lt.PoseTrajectory(TIMES / 20, motion.positions, motion.orientations)
    joints = arm.follow(fast, q0=posture)
    np.testing.assert_array_equal(
        joints.times, arm.follow(fast, q0=posture, on_rate_limit="slow").times
    )
    assert_follows(arm, fast, joints)
    speeds = np.abs(np.diff(joints.positions, axis=0)) / np.diff(joints.times)[:, None]
    assert (speeds <= arm.limits.velocity * (1 + 1e-9)).all()


def test_leaving_the_workspace_names_the_sample(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    away = np.linspace(0, 5, len(TIMES))[:, None] * np.array([1.0, 0.0, 0.0])
    motion = lt.PoseTrajectory(TIMES, position + away, np.tile(orientation, (len(TIMES), 1)))
    with pytest.raises(IkFailure) as failure:
        arm.follow(motion)
    error = failure.value
    assert 0 < error.index < len(TIMES)
    assert error.status in {"limits", "unreachable", "budget"}
    assert error.residual[0] > 1e-6 or error.residual[1] > 1e-6
    assert error.q.shape == (len(arm.joint_names),)
    assert f"sample {error.index}" in str(error)


def test_an_unreachable_start_is_sample_zero(arm):
    motion = lt.Trajectory([0.0, 1.0], [[9.0, 0, 0], [9.0, 0, 0.1]])
    with pytest.raises(IkFailure) as failure:
        arm.follow(motion)
    assert failure.value.index == 0
    assert failure.value.status == "unreachable"


def test_a_path_with_a_jump_is_refused_as_one(arm, posture):
    here, _ = arm.forward_kinematics(posture)
    there = posture.copy()
    there[-4] += 0.9
    there[-6] -= 0.8
    position, _ = arm.forward_kinematics(there)
    motion = lt.Trajectory([0.0, 1.0], [here, position])
    with pytest.raises(IkFailure) as failure:
        arm.follow(motion, q0=posture, options=lt.arm.FollowOptions(max_step=0.01))
    assert failure.value.index == 1
    assert failure.value.status == "jump"


def test_one_sample_stands_still(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    joints = arm.follow(lt.PoseTrajectory([0.0], [position], [orientation]))
    assert joints.positions.shape == (1, len(posture))
    np.testing.assert_array_equal(joints.velocities, 0.0)


def test_the_same_motion_gives_the_same_bits(arm, posture):
    motion = loop(arm, posture)
    np.testing.assert_array_equal(arm.follow(motion).positions, arm.follow(motion).positions)


@pytest.mark.parametrize(
    "motion", [None, np.zeros((3, 3)), lt.Trajectory([0.0, 1.0], [[0, 0], [1, 1]])]
)
def test_other_motions_are_refused(arm, motion):
    with pytest.raises(InvalidInput, match="motion"):
        arm.follow(motion)


@pytest.mark.parametrize(
    "options",
    [{"max_step": 0.0}, {"nullspace_gain": np.nan}, {"position_tolerance": 0.0}],
)
def test_bad_options_are_refused(options):
    with pytest.raises(InvalidInput, match=next(iter(options))):
        lt.arm.FollowOptions(**options)


def test_options_of_another_kind_are_refused(arm, posture):
    with pytest.raises(InvalidInput, match="options: expected FollowOptions"):
        arm.follow(loop(arm, posture), options=lt.arm.IkOptions())


def shown_to_swing(arm, posture):
    """Joints that bring a redundant arm elsewhere while the tool goes round, and their poses."""
    swing = 0.15 * np.sin(np.pi * TIMES / TIMES[-1]) ** 2
    q = posture + np.outer(swing, np.linspace(1.0, -1.0, len(posture)))
    return lt.JointTrajectory(TIMES, q), lt.PoseTrajectory(TIMES, *arm.forward_kinematics(q))


def test_a_redundant_arm_stands_as_it_was_shown_to(arm, posture):
    shown, motion = shown_to_swing(arm, posture)
    joints = arm.follow(motion, options=lt.arm.FollowOptions(posture=shown, nullspace_gain=20.0))
    assert_follows(arm, motion, joints)
    np.testing.assert_allclose(joints.positions, shown.positions, atol=0.02)
    # Another pace is no matter, and names are the arm's where there are any.
    slow = lt.JointTrajectory(3.0 * TIMES + 1.0, shown.positions, joint_names=arm.joint_names)
    again = arm.follow(motion, options=lt.arm.FollowOptions(posture=slow, nullspace_gain=20.0))
    np.testing.assert_allclose(again.positions, joints.positions, atol=1e-9)


@pytest.mark.parametrize("too_fast", ["exceed_limits", "raise"])
def test_a_posture_keeps_a_redundant_arm_nearer_to_it_than_the_middle(arm, posture, too_fast):
    shown, motion = shown_to_swing(arm, posture)
    slow = lt.PoseTrajectory(5.0 * TIMES, motion.positions, motion.orientations)
    away = [
        np.abs(arm.follow(slow, **near, on_rate_limit=too_fast).positions - shown.positions).max()
        for near in ({"options": lt.arm.FollowOptions(posture=shown)}, {"q0": posture})
    ]
    assert away[0] < 0.25
    assert away[0] <= away[1] + 1e-6


def test_a_redundant_arm_goes_to_a_posture(arm, posture):
    position, turned = arm.forward_kinematics(posture)
    still = lt.PoseTrajectory(
        5.0 * TIMES, np.tile(position, (400, 1)), np.tile(turned, (len(TIMES), 1))
    )
    begun = arm.inverse_kinematics(
        position, turned, q0=posture, options=lt.arm.IkOptions(nullspace_gain=1.0)
    ).q
    joints = arm.follow(still, q0=begun, options=lt.arm.FollowOptions(posture=posture))
    np.testing.assert_allclose(joints.positions[-1], posture, atol=1e-3)


@pytest.mark.parametrize("wrong", [np.zeros(3), "up", lt.JointTrajectory([0, 1], np.zeros((2, 3)))])
def test_a_posture_of_other_joints_is_refused(arm, posture, wrong):
    with pytest.raises(InvalidInput, match="posture"):
        arm.follow(loop(arm, posture), options=lt.arm.FollowOptions(posture=wrong))
