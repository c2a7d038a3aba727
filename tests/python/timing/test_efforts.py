"""Motions whose torques are limited to little more than holding the arm takes."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import trajectories as tr

UR3 = lt.Arm.load("ur3").with_payload(1.5, (0.0, 0.0, 0.1))
START = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])


@pytest.mark.parametrize("timed", [lt.retime, lt.keep_timing])
@pytest.mark.parametrize("room", [(1.02, 0.2), (1.1, 0.5), (1.2, 1.0)])
def test_a_motion_that_can_be_held_is_slowed_down_to_its_torques(timed, room):
    share, joints = np.linspace(0.0, 1.0, 201), np.linspace(0.3, -0.2, 6)
    way = np.outer(tr.minimum_jerk_time_scaling(share), joints)
    path = lt.JointTrajectory(share, START + way)
    held = np.abs(UR3.gravity_torques(path.positions)).max(axis=0)
    limits = replace(UR3.limits, effort=room[0] * held + room[1])
    motion = timed(path, limits, inverse_dynamics=UR3.inverse_dynamics)
    torques = UR3.inverse_dynamics(motion.positions, motion.velocities, motion.accelerations)
    used = (np.abs(torques) / limits.effort).max()
    assert used < 1.002
    assert timed is lt.keep_timing or used > 0.9
    assert lt.check_limits(motion, limits).ok
