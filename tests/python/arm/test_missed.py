"""What an arm says of a path that it cannot follow although it reaches both of its ends."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import IkFailure

PANDA = lt.Arm.load("panda")
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
OUT_AND_BACK = np.sin(np.linspace(0.0, np.pi, 80))[:, None]
TIMES = np.linspace(0.0, 4.0, 80)


def excursion(offset=(0.0, 0.0, 0.0), spin=0.0):
    """Poses that leave those of HOME by an offset and a spin of the tool, and come back."""
    position, turned = PANDA.forward_kinematics(HOME)
    spun = lt.rotations.exp(OUT_AND_BACK * [0.0, 0.0, spin])
    orientations = lt.rotations.compose(np.tile(turned, (80, 1)), spun)
    return lt.PoseTrajectory(TIMES, position + OUT_AND_BACK * np.array(offset), orientations)


def failure_of(motion, **options):
    with pytest.raises(IkFailure) as failure:
        PANDA.follow(motion, **options)
    assert 0 < failure.value.index < len(motion) - 1
    return failure.value


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


def test_a_pose_beyond_the_reach_is_told_with_how_far_the_motion_goes():
    motion = excursion((0.45, 0.0, 0.0))  # within the length of the arm, and not with this tool
    error = failure_of(motion)
    assert error.status == "unreachable"
    told = str(error).split("the motion goes up to ")[1].split()
    farthest = PANDA.inverse_kinematics(motion.positions[40], motion.orientations[40])
    assert float(told[0]) == pytest.approx(farthest.position_error, rel=0.02)
    assert float(told[3]) == pytest.approx(farthest.orientation_error, rel=0.02)


def test_the_joint_at_its_limit_is_named_where_the_arm_would_have_to_jump():
    error = failure_of(excursion(spin=5.5), q0=HOME)
    assert error.status == "jump"
    assert error.limiting_joints
    assert f"{error.limiting_joints[0]} at its" in str(error)


def test_the_joint_that_would_have_to_leap_is_named():
    position, _ = PANDA.forward_kinematics(HOME)
    there, _ = PANDA.forward_kinematics(HOME + np.array([0.0, 0.4, 0.0, 0.9, 0.0, 0.0, 0.0]))
    motion = lt.Trajectory([0.0, 1.0, 2.0], [position, there, position])
    error = failure_of(motion, q0=HOME, options=lt.arm.FollowOptions(max_step=0.01))
    assert error.status == "jump"
    assert error.limiting_joints == ()
    name, _, rest = str(error).partition(" would have to move by ")
    assert name.split()[-1] in PANDA.joint_names
    assert float(rest.split()[0]) > 0.1
