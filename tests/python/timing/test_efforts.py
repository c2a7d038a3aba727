"""Motions whose torques are limited to little more than holding the arm takes."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import raised

import leadthrough as lt
from leadthrough import trajectories as tr
from leadthrough.errors import LimitsInfeasible

UR3 = lt.Arm.load("ur3").with_payload(1.5, (0.0, 0.0, 0.1))
START = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])


# N m s/rad and N m.
FRICTIONS = [(0.0, 0.0), (1.0, 0.0), (10.0, 0.0), (0.0, 0.1), (3.0, 0.1)]


def reach(joints):
    share = np.linspace(0.0, 1.0, 201)
    return lt.JointTrajectory(share, START + np.outer(tr.minimum_jerk_time_scaling(share), joints))


@pytest.mark.parametrize("timed", [lt.retime, lt.keep_timing])
@pytest.mark.parametrize("room", [(1.02, 0.2), (1.1, 0.5), (1.2, 1.0)])
@pytest.mark.parametrize(("viscous", "dry"), FRICTIONS)
def test_a_motion_that_can_be_held_is_slowed_down_to_its_torques(timed, room, viscous, dry):
    def torques(q, qd, qdd):
        return UR3.inverse_dynamics(q, qd, qdd) + viscous * qd + dry * np.sign(qd)

    path = reach(np.linspace(0.3, -0.2, 6))
    held = np.abs(UR3.gravity_torques(path.positions)).max(axis=0)
    limits = replace(UR3.limits, effort=room[0] * held + room[1])
    motion = timed(path, limits, inverse_dynamics=torques)
    needed = torques(motion.positions, motion.velocities, motion.accelerations)
    used = (np.abs(needed) / limits.effort).max()
    assert used < 1.002
    assert timed is lt.keep_timing or used > 0.9
    assert lt.check_limits(motion, limits).ok


def test_a_joint_that_cannot_overcome_its_friction_is_named():
    def torques(q, qd, qdd):
        return UR3.inverse_dynamics(q, qd, qdd) + 15.0 * np.sign(qd)  # the limit of the wrist is 12

    call = lt.retime, reach(np.linspace(0.3, -0.2, 6)), UR3.limits
    error = raised(LimitsInfeasible, *call, inverse_dynamics=torques)
    assert "wrist_1_joint cannot overcome its friction" in str(error)


def test_viscous_friction_alone_gives_the_steady_speed():
    """A joint with 2 N m against 4 N m s/rad turns at 0.5 rad/s."""

    def torques(q, qd, qdd):
        return 0.01 * qdd + 4.0 * qd

    bounds = {"velocity": [5.0], "acceleration": [50.0], "jerk": [5e3], "effort": [2.0]}
    limits = lt.arm.JointLimits(("joint",), [-9.0], [9.0], **bounds)
    motion = lt.retime(np.array([[0.0], [3.0]]), limits, inverse_dynamics=torques)
    assert motion.velocities.max() == pytest.approx(0.5, rel=2e-3)
    assert motion.duration == pytest.approx(6.0, abs=0.05)
