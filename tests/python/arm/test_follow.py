"""Following a motion: without a jump, near a posture, with free axes, and why it fails."""

import dataclasses

import numpy as np
import pytest
import so101
from refusals import raised, refused

import leadthrough as lt
from leadthrough.arm import FollowOptions, IkOptions
from leadthrough.errors import IkFailure, InvalidInput

PANDA = lt.Arm.load("panda")
FIVE = lt.Arm.from_urdf(so101.URDF, tip=so101.TIP)
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
TIMES = np.linspace(0.0, 4.0, 400)
U = np.linspace(0.0, 1.0, 80)[:, None]
OUT_AND_BACK = np.sin(np.pi * U)


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


@pytest.mark.parametrize("given", [True, False])
def test_a_smooth_path_is_followed_without_a_jump(arm, posture, given):
    motion = loop(arm, posture)
    q0 = posture if given else None
    joints = arm.follow(motion, q0=q0, on_rate_limit="exceed_limits")
    assert_follows(arm, motion, joints)
    assert np.abs(np.diff(joints.positions, axis=0)).max() < 0.05
    assert joints.joint_names == arm.joint_names
    np.testing.assert_array_equal(joints.times, motion.times)


def test_points_leave_the_orientation_free(arm, posture):
    poses = loop(arm, posture)
    motion = lt.Trajectory(poses.times, poses.positions)
    joints = arm.follow(motion)
    assert_follows(arm, motion, joints)


def test_a_start_keeps_its_posture(arm, posture):
    joints = arm.follow(loop(arm, posture), q0=posture, options=FollowOptions(nullspace_gain=0.0))
    np.testing.assert_allclose(joints.positions[0], posture, atol=1e-4)


def test_velocities_and_accelerations_are_the_positions_derivatives(arm, posture):
    joints = arm.follow(loop(arm, posture), q0=posture, on_rate_limit="exceed_limits")
    integrals = ((joints.velocities, joints.positions), (joints.accelerations, joints.velocities))
    for rates, values in integrals:
        gained = np.trapezoid(rates, TIMES, axis=0)
        np.testing.assert_allclose(gained, values[-1] - values[0], atol=1e-3)


def test_the_pull_moves_a_redundant_arm_and_not_the_tool(arm, posture):
    motion = loop(arm, posture, size=0.0)
    still = lt.PoseTrajectory(TIMES, motion.positions, np.tile(motion.orientations[0], (400, 1)))
    joints = arm.follow(still, q0=posture, options=FollowOptions(nullspace_gain=0.5))
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
    failure = raised(IkFailure, arm.follow, fast, q0=posture, on_rate_limit="raise")
    assert failure.status == "rate_limit"


def test_by_default_a_motion_that_is_too_fast_is_slowed_and_every_step_bounded(arm, posture):
    motion = loop(arm, posture)
    fast = lt.PoseTrajectory(TIMES / 20, motion.positions, motion.orientations)
    joints = arm.follow(fast, q0=posture)
    np.testing.assert_array_equal(
        joints.times, arm.follow(fast, q0=posture, on_rate_limit="slow").times
    )
    assert_follows(arm, fast, joints)
    speeds = np.abs(np.diff(joints.positions, axis=0)) / np.diff(joints.times)[:, None]
    assert (speeds <= arm.limits.velocity * (1 + 1e-9)).all()


def test_a_path_with_a_jump_is_refused_as_one(arm, posture):
    here, _ = arm.forward_kinematics(posture)
    there = posture.copy()
    there[-4] += 0.9
    there[-6] -= 0.8
    position, _ = arm.forward_kinematics(there)
    motion = lt.Trajectory([0.0, 1.0], [here, position])
    with pytest.raises(IkFailure) as failure:
        arm.follow(motion, q0=posture, options=FollowOptions(max_step=0.01))
    assert failure.value.index == 1
    assert failure.value.status == "jump"


def test_by_default_no_joint_moves_by_more_than_half_a_radian_between_samples():
    turned = HOME + np.array([1.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    motion = lt.PoseTrajectory([0.0, 1.0], *PANDA.forward_kinematics(np.stack([HOME, turned])))
    steps = []
    for options in (FollowOptions(), FollowOptions(max_step=1.0)):
        joints = PANDA.follow(motion, q0=HOME, options=options, on_rate_limit="exceed_limits")
        steps.append(np.abs(np.diff(joints.positions, axis=0)).max())
    assert steps[0] <= 0.5 < steps[1]


def swing(arm, posture):
    """Joints that bring a redundant arm elsewhere while the tool goes round, and their poses."""
    bow = 0.15 * np.sin(np.pi * TIMES / TIMES[-1]) ** 2
    q = posture + np.outer(bow, np.linspace(1.0, -1.0, len(posture)))
    return lt.JointTrajectory(TIMES, q), lt.PoseTrajectory(TIMES, *arm.forward_kinematics(q))


def test_a_redundant_arm_takes_the_demonstrated_posture(arm, posture):
    shown, motion = swing(arm, posture)
    joints = arm.follow(motion, options=FollowOptions(posture=shown, nullspace_gain=20.0))
    assert_follows(arm, motion, joints)
    np.testing.assert_allclose(joints.positions, shown.positions, atol=0.02)
    # Another pace is no matter, and names are the arm's where there are any.
    slow = lt.JointTrajectory(3.0 * TIMES + 1.0, shown.positions, joint_names=arm.joint_names)
    again = arm.follow(motion, options=FollowOptions(posture=slow, nullspace_gain=20.0))
    np.testing.assert_allclose(again.positions, joints.positions, atol=1e-9)


@pytest.mark.parametrize("on_rate_limit", ["exceed_limits", "raise"])
def test_a_posture_keeps_a_redundant_arm_nearer_to_it_than_the_middle(arm, posture, on_rate_limit):
    shown, motion = swing(arm, posture)
    slow = lt.PoseTrajectory(5.0 * TIMES, motion.positions, motion.orientations)
    away = [
        np.abs(
            arm.follow(slow, **near, on_rate_limit=on_rate_limit).positions - shown.positions
        ).max()
        for near in ({"options": FollowOptions(posture=shown)}, {"q0": posture})
    ]
    assert away[0] < 0.25
    assert away[0] <= away[1] + 1e-6


def test_a_redundant_arm_goes_to_a_posture(arm, posture):
    position, turned = arm.forward_kinematics(posture)
    still = lt.PoseTrajectory(
        5.0 * TIMES, np.tile(position, (400, 1)), np.tile(turned, (len(TIMES), 1))
    )
    begun = arm.inverse_kinematics(
        position, turned, q0=posture, options=IkOptions(nullspace_gain=1.0)
    ).q
    joints = arm.follow(still, q0=begun, options=FollowOptions(posture=posture))
    np.testing.assert_allclose(joints.positions[-1], posture, atol=1e-3)


def excursion(offset=(0.0, 0.0, 0.0), spin=0.0):
    """Poses that leave those of HOME by an offset and a spin of the tool, and come back."""
    position, turned = PANDA.forward_kinematics(HOME)
    spun = lt.rotations.exp(OUT_AND_BACK * [0.0, 0.0, spin])
    orientations = lt.rotations.compose(np.tile(turned, (80, 1)), spun)
    return lt.PoseTrajectory(
        4.0 * U[:, 0], position + OUT_AND_BACK * np.array(offset), orientations
    )


def failure_of(motion, **options):
    failure = raised(IkFailure, PANDA.follow, motion, **options)
    assert 0 < failure.index < len(motion) - 1
    assert f"sample {failure.index}" in str(failure)
    assert failure.q.shape == (7,)
    return failure


def test_the_joints_whose_limits_keep_the_tip_from_a_pose_are_named():
    position, _ = PANDA.forward_kinematics(HOME)
    error = failure_of(excursion(-position))
    assert error.status == "limits"
    assert error.limiting_joints
    for name in error.limiting_joints:
        j = PANDA.joint_names.index(name)
        side = "lower" if error.q[j] < 0.0 else "upper"
        limit = getattr(PANDA.limits, side)[j]
        assert error.q[j] == pytest.approx(limit, abs=1e-3)
        assert f"{name} at its {side} limit {limit:.4g}" in str(error)


def test_a_pose_beyond_the_reach_is_reported_with_how_far_the_motion_goes():
    motion = excursion((0.45, 0.0, 0.0))  # within the length of the arm, and not with this tool
    error = failure_of(motion)
    assert error.status == "unreachable"
    reported = str(error).split("the motion goes up to ")[1].split()
    farthest = PANDA.inverse_kinematics(motion.positions[40], motion.orientations[40])
    assert float(reported[0]) == pytest.approx(farthest.position_error, rel=0.02)
    assert float(reported[3]) == pytest.approx(farthest.orientation_error, rel=0.02)


def test_the_joint_at_its_limit_is_named_where_the_arm_would_have_to_jump():
    error = failure_of(excursion(spin=5.5), q0=HOME)
    assert error.status == "jump"
    assert error.limiting_joints
    assert f"{error.limiting_joints[0]} at its" in str(error)


def test_the_joint_that_would_have_to_leap_is_named():
    position, _ = PANDA.forward_kinematics(HOME)
    there, _ = PANDA.forward_kinematics(HOME + np.array([0.0, 0.4, 0.0, 0.9, 0.0, 0.0, 0.0]))
    motion = lt.Trajectory([0.0, 1.0, 2.0], [position, there, position])
    error = failure_of(motion, q0=HOME, options=FollowOptions(max_step=0.01))
    assert error.status == "jump"
    assert error.limiting_joints == ()
    name, _, rest = str(error).partition(" would have to move by ")
    assert name.split()[-1] in PANDA.joint_names
    assert float(rest.split()[0]) > 0.1


def moved(offset):
    """A path that the five joints can follow at first, and less and less the farther it goes."""
    ((q, _),) = so101.motions(1, samples=80)
    shown = FIVE.poses(lt.JointTrajectory(3.0 * U[:, 0], q, joint_names=so101.JOINTS))
    positions = shown.positions + U * offset
    return lt.PoseTrajectory(shown.times, positions, shown.orientations, joints=shown.joints)


@pytest.mark.parametrize(
    ("offset", "most"),
    [
        ((0.0, 0.02, 0.0), 0.05),
        ((0.0, -0.02, 0.0), 0.05),
        ((0.02, 0.0, -0.01), 0.05),
        ((0.06, -0.01, -0.02), 0.25),  # no single axis lets them follow
    ],
)
def test_five_joints_keep_the_position_and_have_the_least_orientation_error(offset, most):
    motion = moved(offset)
    report = FIVE.path_report(FIVE.follow(motion), motion)
    assert report.position_error.max() < 1e-5
    errors = []
    for axes in (["rx"], ["ry"], ["rz"], ["rx", "ry", "rz"]):
        try:
            made = FIVE.follow(motion, options=FollowOptions(free=axes))
        except IkFailure:
            continue
        errors.append(FIVE.path_report(made, motion).orientation_error.max())
    assert report.orientation_error.max() == pytest.approx(min(errors), abs=1e-9)
    assert report.orientation_error.max() < most


def test_a_path_within_five_joints_is_followed_with_no_axis_free_and_another_is_not():
    motion = moved((0.0, 0.0, 0.0))
    report = FIVE.path_report(FIVE.follow(motion), motion)
    assert report.orientation_error.max() < 1e-5
    with pytest.raises(IkFailure):
        FIVE.follow(moved((0.0, 0.02, 0.0)), options=FollowOptions(free=()))


def test_a_tool_that_may_spin_keeps_its_axis():
    home = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.8])
    position, turned = PANDA.forward_kinematics(home)
    # Turned by more than the last joint can: only with the spin free the path can be followed.
    spin = lt.rotations.exp(np.outer(U[:, 0] * 5.5, [0.0, 0.0, 1.0]))
    orientations = lt.rotations.compose(np.tile(turned, (80, 1)), spin)
    way = position + U * [0.0, 0.1, 0.0]
    motion = lt.PoseTrajectory(4.0 * U[:, 0], way, orientations)
    with pytest.raises(IkFailure):
        PANDA.follow(motion, q0=home)
    made = PANDA.follow(motion, q0=home, options=FollowOptions(free=["rz"]))
    reached = PANDA.poses(made)
    assert np.abs(reached.positions - way).max() < 1e-5
    asked = lt.rotations.to_matrix(orientations)[:, :, 2]
    assert np.abs(lt.rotations.to_matrix(reached.orientations)[:, :, 2] - asked).max() < 1e-4


FLAT = lt.Trajectory([0.0, 1.0], [[0, 0], [1, 1]])
FEWER = lt.JointTrajectory([0, 1], np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        *(({"motion": motion}, "motion") for motion in (None, np.zeros((3, 3)), FLAT)),
        ({"options": IkOptions()}, "options: expected FollowOptions"),
        ({"max_step": 0.0}, "max_step"),
        ({"nullspace_gain": np.nan}, "nullspace_gain"),
        ({"position_tolerance": 0.0}, "position_tolerance"),
        *(({"posture": posture}, "posture") for posture in (np.zeros(3), "up", FEWER)),
        ({"free": ["spin"]}, "free: expected one of"),
        ({"free": "rz"}, "free: expected a collection"),
        ({"free": ["x", "y", "z", "rx", "ry", "rz"]}, "at least one axis"),
        ({"free": ["rz"], "on_rate_limit": "raise"}, "free: not used with on_rate_limit"),
    ],
)
def test_wrong_arguments_and_options_are_refused(arguments, message):
    of_options = {"max_step", "nullspace_gain", "position_tolerance", "posture", "free"}
    options = {name: arguments[name] for name in of_options & set(arguments)}
    others = {name: arguments[name] for name in set(arguments) - of_options}
    with pytest.raises(InvalidInput, match=message):
        given = {"motion": moved((0.0, 0.0, 0.0)), "options": FollowOptions(**options)}
        FIVE.follow(**given | others)


def test_points_leave_no_rotation_to_free():
    motion = moved((0.0, 0.0, 0.0))
    points = lt.Trajectory(motion.times, motion.positions)
    with pytest.raises(InvalidInput, match="free: expected one or two of 'x', 'y', 'z'"):
        FIVE.follow(points, options=FollowOptions(free=["rz"]))
    made = FIVE.follow(points, options=FollowOptions(free=["z"]))
    assert np.abs(FIVE.poses(made).positions - motion.positions)[:, :2].max() < 1e-5


ARM = lt.Arm.load("ur3")
CLOCK = np.linspace(0.0, 2.0, 50)
Q = np.array([0, -1.2, 1.4, -1.7, -1.5, 0.3]) + 0.2 * np.sin(CLOCK)[:, None]
JOINTS = lt.JointTrajectory(CLOCK, Q)
MOTION = lt.PoseTrajectory(CLOCK, *ARM.forward_kinematics(Q))

OFFSET = 0.01 * np.eye(6)


def test_a_trajectory_on_its_own_poses_has_no_error():
    report = ARM.path_report(JOINTS, MOTION)
    assert report.position_error.max() < 1e-12
    assert report.orientation_error.max() < 1e-12
    np.testing.assert_allclose(report.condition_number, ARM.condition_number(Q))


def test_shares_are_those_of_positions_that_are_run_straight():
    report = ARM.path_report(JOINTS, MOTION)
    judged = lt.check_limits(JOINTS, ARM.limits, linear_rate=49.0 / 2.0)
    np.testing.assert_allclose(report.velocity_ratio.max(), judged.velocity.ratio)
    np.testing.assert_allclose(report.acceleration_ratio.max(), judged.acceleration.ratio)
    lower, upper = ARM.limits.lower[:5], ARM.limits.upper[:5]  # the last joint turns freely
    margin = np.minimum(Q[:, :5] - lower, upper - Q[:, :5]) / (upper - lower)
    np.testing.assert_allclose(report.margin, margin.min(axis=1))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"positions": Q + OFFSET[0]}, "position error"),
        ({"positions": Q + OFFSET[5]}, "orientation error"),
        ({"times": CLOCK / 100}, "velocity"),
        ({"positions": Q + 700 * OFFSET[0]}, "margin"),
    ],
)
def test_what_is_wrong_is_not_ok(change, text):
    report = ARM.path_report(dataclasses.replace(JOINTS, **change), MOTION)
    assert not report.ok
    assert text in report.summary()
    assert "not ok" in report.summary()


def test_a_slow_trajectory_is_ok():
    report = ARM.path_report(lt.JointTrajectory(10 * CLOCK, Q), MOTION)
    assert report.ok
    assert report.summary().startswith("50 samples, ok")


def test_points_ask_for_no_orientation_and_unknown_accelerations_for_none():
    limits = dataclasses.replace(ARM.limits, acceleration=None)
    arm = lt.Arm(ARM.document, ARM.base, ARM.tip, limits)
    report = arm.path_report(JOINTS, lt.Trajectory(CLOCK, MOTION.positions))
    assert report.acceleration_ratio is None
    assert (report.orientation_error == 0.0).all()
    assert "acceleration" not in report.summary()
    one = arm.path_report(
        lt.JointTrajectory([0.0], Q[:1]), lt.Trajectory([0.0], MOTION.positions[:1])
    )
    assert one.velocity_ratio.shape == (1,)
    assert one.ok


@pytest.mark.parametrize(
    ("joints", "motion", "options", "name"),
    [
        (None, MOTION, {}, "trajectory"),
        (Q, MOTION, {}, "trajectory"),
        (lt.JointTrajectory(CLOCK[1:], Q[1:]), MOTION, {}, "trajectory"),
        (lt.JointTrajectory(CLOCK, Q[:, 1:]), MOTION, {}, "trajectory"),
        (JOINTS, JOINTS, {}, "motion"),
        (JOINTS, MOTION, {"position_tolerance": 0.0}, "position_tolerance"),
    ],
)
def test_other_motions_and_tolerances_are_refused(joints, motion, options, name):
    refused(name, ARM.path_report, joints, motion, **options)
