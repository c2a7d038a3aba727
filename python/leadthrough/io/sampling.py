"""Joint trajectories at the even rate that a controller works at."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.joint_trajectory import resting_at_both_ends
from leadthrough.motion import JointTrajectory

_MOST = 10_000_000  # samples of a file; three hours at 1 kHz


def at_rate(
    trajectory: JointTrajectory, rate: float
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Times (n,) from 0 on, positions and velocities (n, joints) at a rate, Hz.

    By cubic Hermite curves through positions and velocities; samples at the rate already stay as
    they are. It ends where the trajectory ends, less than a step later.
    Raises InvalidInput for a motion without velocities, or one that does not start and end at rest.
    """
    velocities = resting_at_both_ends(trajectory.velocities)
    if len(trajectory.times) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    if trajectory.duration * rate > _MOST:
        raise InvalidInput(
            f"trajectory: expected at most {_MOST:,} samples at {rate:g} Hz, "
            f"it takes {trajectory.duration:.6g} s"
        )
    own = trajectory.times - trajectory.times[0]
    # A step that ends within a millionth of itself needs no other one behind it.
    times = np.arange(math.ceil(trajectory.duration * rate - 1e-6) + 1) / rate
    if len(own) == len(times) and np.allclose(own, times, rtol=0.0, atol=1e-6 / rate):
        return times, trajectory.positions, velocities
    curve = CubicHermiteSpline(own, trajectory.positions, velocities)
    within = np.minimum(times, own[-1])
    sampled, speeds = np.asarray(curve(within)), np.asarray(curve(within, 1))
    sampled[-1], speeds[-1] = trajectory.positions[-1], 0.0
    return times, sampled, speeds
