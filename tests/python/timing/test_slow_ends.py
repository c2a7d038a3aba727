"""Motions that begin or end at almost no speed, as a measured one is."""

import numpy as np
import pytest

import leadthrough as lt

PANDA = lt.Arm.load("panda").limits
MIDDLE = 0.5 * (PANDA.lower + PANDA.upper)


@pytest.mark.parametrize("speed", [1e-17, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3])
def test_a_motion_that_hardly_moves_at_its_ends_takes_hardly_longer_than_from_rest(speed):
    rates, share = np.linspace(0.5, 3.0, 7), np.linspace(0.0, 1.0, 101)[:, None]
    path = lt.JointTrajectory(share[:, 0], MIDDLE + 0.2 * np.sin(share * rates))
    slow = [speed * rates, speed * rates * np.cos(rates)]
    rest = lt.retime(path, PANDA)
    motion = lt.retime(path, PANDA, start_velocity=slow[0], end_velocity=slow[1])
    assert motion.duration < 1.15 * rest.duration
    for row, velocity in zip((0, -1), slow, strict=True):
        np.testing.assert_allclose(motion.velocities[row], velocity, atol=1e-8, rtol=1e-2)
