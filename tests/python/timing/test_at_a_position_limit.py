"""Motions that touch a position limit: samples keep it, a smooth path near them might not."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import trajectories as tr
from leadthrough.errors import LimitsInfeasible

PANDA = lt.Arm.load("panda").limits
MIDDLE = 0.5 * (PANDA.lower + PANDA.upper)


def swing(beyond, samples=101):
    """Out to the first joint's upper limit, and by a fraction beyond, and back."""
    times = np.linspace(0.0, 2.0, samples)
    u = tr.minimum_jerk_time_scaling(0.5 * times)
    q = MIDDLE + 0.3 * np.outer(u, np.ones(7))
    q[:, 0] = MIDDLE[0] + (1.0 + beyond) * (PANDA.upper[0] - MIDDLE[0]) * np.sin(np.pi * u)
    return times, q


@pytest.mark.parametrize("path_tolerance", [1e-6, 1e-5, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("samples", [100, 101])  # with one at the top and without
def test_a_motion_that_touches_its_limit_keeps_it_and_its_samples(samples, path_tolerance):
    times, q = swing(0.0, samples)
    motion = lt.retime(lt.JointTrajectory(times, q), PANDA, path_tolerance=path_tolerance)
    assert (motion.positions <= PANDA.upper + 1e-9).all()
    for sample in q[::10]:
        # Between two samples of the motion, at 1 kHz, the arm moves by less than 6e-3.
        assert np.abs(motion.positions - sample).max(axis=1).min() < path_tolerance + 3e-3
    top = MIDDLE[0] + (PANDA.upper[0] - MIDDLE[0]) * (1.0 - 2e-4)
    assert motion.positions[:, 0].max() > min(top, PANDA.upper[0] - 2.0 * path_tolerance)


def test_samples_held_at_the_limit_stay_there():
    times, q = swing(0.05)
    held = np.minimum(q, PANDA.upper)
    motion = lt.retime(lt.JointTrajectory(times, held), PANDA, path_tolerance=1e-3)
    assert (motion.positions <= PANDA.upper + 1e-9).all()
    assert (motion.positions[:, 0] > PANDA.upper[0] - 2e-3).sum() > 100


def test_rounding_beyond_the_limit_and_a_tolerance_wider_than_a_joint_are_borne():
    times, q = swing(0.0)
    q[:, 0] += 5e-10
    assert lt.retime(lt.JointTrajectory(times, q), PANDA).duration < 4.0
    upper = PANDA.upper.copy()
    upper[1] = PANDA.lower[1] + 0.01
    narrow = replace(PANDA, upper=upper)
    q[:, 1] = upper[1] - 0.01 * np.sin(0.5 * np.pi * times) ** 2
    motion = lt.retime(lt.JointTrajectory(times, q), narrow, path_tolerance=0.012)
    assert (motion.positions >= narrow.lower - 1e-9).all()
    assert (motion.positions <= narrow.upper + 1e-9).all()


def test_what_leaves_a_limit_is_refused_with_the_amount():
    times, q = swing(0.01)
    beyond = 0.01 * (PANDA.upper[0] - MIDDLE[0])
    with pytest.raises(LimitsInfeasible, match=rf"position limits .* by {beyond:.2g}"):
        lt.retime(lt.JointTrajectory(times, q), PANDA)
