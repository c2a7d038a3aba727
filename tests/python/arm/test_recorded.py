"""Recorded joints as the arm's own, and as poses of its tip."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput

ARM = lt.Arm.load("panda")
TIMES = np.linspace(0.0, 1.0, 20)
MIDDLE = 0.5 * (ARM.limits.lower + ARM.limits.upper)
Q = MIDDLE + 0.3 * np.sin(TIMES[:, None] * np.arange(1, 8))


def recording(names, columns, **more):
    return lt.JointTrajectory(TIMES, Q[:, columns], joint_names=names, **more)


def test_joints_are_found_by_name_among_others_in_any_order():
    shuffled = [6, 0, 3, 1, 5, 2, 4]
    names = ("finger", *(ARM.joint_names[i] for i in shuffled))
    found = ARM.joints_of(recording(names, [0, *shuffled], velocities=Q[:, [0, *shuffled]]))
    assert found.joint_names == ARM.joint_names
    assert np.array_equal(found.positions, Q)
    assert np.array_equal(found.velocities, Q)
    assert found.accelerations is None


def test_poses_are_the_tips_at_every_sample_and_keep_events():
    happens = (lt.Event(0.4, "close"),)
    motion = ARM.poses(lt.JointTrajectory(TIMES, Q, events=happens))
    positions, orientations = ARM.forward_kinematics(Q)
    assert np.array_equal(motion.positions, positions)
    # PoseTrajectory may turn a quaternion's sign.
    assert np.allclose(np.abs(np.sum(motion.orientations * orientations, axis=1)), 1.0)
    assert np.array_equal(motion.times, TIMES)
    assert motion.events == happens


def test_follow_leads_back_to_the_joints_poses():
    motion = ARM.poses(lt.JointTrajectory(TIMES, Q))
    back = ARM.poses(ARM.follow(motion, seed=Q[0]))
    assert np.abs(back.positions - motion.positions).max() < 1e-5


@pytest.mark.parametrize(
    "wrong",
    [
        Q,
        lt.JointTrajectory(TIMES, Q[:, :6]),
        lt.JointTrajectory(TIMES, Q, joint_names=tuple("abcdefg")),
        lt.PoseTrajectory([0.0], [(0, 0, 0)], [(1, 0, 0, 0)]),
    ],
)
def test_other_joints_are_refused(wrong):
    with pytest.raises(InvalidInput, match="trajectory"):
        ARM.poses(wrong)
