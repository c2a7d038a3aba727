"""Axes that are left free along a path, by choice or for want of joints."""

import numpy as np
import pytest
import so101

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput

FIVE = lt.Arm.from_urdf(so101.URDF, tip=so101.TIP)
PANDA = lt.Arm.load("panda")
U = np.linspace(0.0, 1.0, 80)[:, None]


def moved(offset):
    """A path that the five joints can follow at first, and less and less the farther it goes."""
    ((q, _),) = so101.motions(1, samples=80)
    shown = FIVE.poses(lt.JointTrajectory(3.0 * U[:, 0], q, joint_names=so101.JOINTS))
    positions = shown.positions + U * offset
    return lt.PoseTrajectory(shown.times, positions, shown.orientations, joints=shown.joints)


@pytest.mark.parametrize("offset", [(0.0, 0.02, 0.0), (0.0, -0.02, 0.0), (0.02, 0.0, -0.01)])
def test_five_joints_keep_the_position_and_turn_away_least(offset):
    motion = moved(offset)
    report = FIVE.path_report(FIVE.follow(motion), motion)
    assert report.position_error.max() < 1e-5
    errors = []
    for axis in ("rx", "ry", "rz"):
        try:
            made = FIVE.follow(motion, options=lt.arm.FollowOptions(free=[axis]))
        except IkFailure:
            continue
        errors.append(FIVE.path_report(made, motion).orientation_error.max())
    assert report.orientation_error.max() == pytest.approx(min(errors), abs=1e-9)
    assert report.orientation_error.max() < 0.05


def test_what_five_joints_can_do_is_done_with_no_axis_free():
    motion = moved((0.0, 0.0, 0.0))
    report = FIVE.path_report(FIVE.follow(motion), motion)
    assert report.orientation_error.max() < 1e-5


def test_with_no_axis_free_the_pose_is_told_to_be_out_of_reach():
    with pytest.raises(IkFailure):
        FIVE.follow(moved((0.0, 0.02, 0.0)), options=lt.arm.FollowOptions(free=()))


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
    made = PANDA.follow(motion, q0=home, options=lt.arm.FollowOptions(free=["rz"]))
    reached = PANDA.poses(made)
    assert np.abs(reached.positions - way).max() < 1e-5
    asked = lt.rotations.to_matrix(orientations)[:, :, 2]
    assert np.abs(lt.rotations.to_matrix(reached.orientations)[:, :, 2] - asked).max() < 1e-4


@pytest.mark.parametrize(
    ("free", "more", "says"),
    [
        (["spin"], {}, "free: expected one of"),
        ("rz", {}, "free: expected a collection"),
        (["x", "y", "z", "rx", "ry", "rz"], {}, "at least one axis"),
        (["rz"], {"on_rate_limit": "raise"}, "free: not used with on_rate_limit"),
    ],
)
def test_axes_that_cannot_be_free_are_refused(free, more, says):
    with pytest.raises(InvalidInput, match=says):
        FIVE.follow(moved((0.0, 0.0, 0.0)), options=lt.arm.FollowOptions(free=free), **more)


def test_points_leave_no_rotation_to_free():
    motion = moved((0.0, 0.0, 0.0))
    points = lt.Trajectory(motion.times, motion.positions)
    with pytest.raises(InvalidInput, match="free: expected one or two of 'x', 'y', 'z'"):
        FIVE.follow(points, options=lt.arm.FollowOptions(free=["rz"]))
    made = FIVE.follow(points, options=lt.arm.FollowOptions(free=["z"]))
    assert np.abs(FIVE.poses(made).positions - motion.positions)[:, :2].max() < 1e-5
