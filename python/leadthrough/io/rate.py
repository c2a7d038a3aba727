"""Joint trajectories at the constant rate of a controller."""

from __future__ import annotations

import math

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.joint_trajectory import resting_at_both_ends
from leadthrough.motion import JointTrajectory

_MOST = 10_000_000  # samples in a file; three hours at 1 kHz


def at_rate(
    trajectory: JointTrajectory, rate: float
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Evenly spaced samples of a trajectory, on cubic Hermite curves through its own."""
    velocities = resting_at_both_ends(trajectory.velocities)
    if len(trajectory.times) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    if trajectory.duration * rate > _MOST:
        raise InvalidInput(
            f"trajectory: expected at most {_MOST:,} samples at {rate:g} Hz, "
            f"got a duration of {trajectory.duration:.6g} s"
        )
    own = trajectory.times - trajectory.times[0]
    # A duration within a millionth of a step of whole steps needs no further step.
    times = np.arange(math.ceil(trajectory.duration * rate - 1e-6) + 1) / rate
    if len(own) == len(times) and np.allclose(own, times, rtol=0.0, atol=1e-6 / rate):
        return times, trajectory.positions, velocities
    return times, *_interpolated(trajectory, velocities, np.minimum(times, own[-1]))


def _interpolated(
    trajectory: JointTrajectory, velocities: Float64Array, times: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Positions and velocities at times (n,) from the trajectory's start, at rest at the end."""
    from scipy.interpolate import CubicHermiteSpline

    own = trajectory.times - trajectory.times[0]
    curve = CubicHermiteSpline(own, trajectory.positions, velocities)
    positions, speeds = np.asarray(curve(times)), np.asarray(curve(times, 1))
    positions[-1], speeds[-1] = trajectory.positions[-1], 0.0
    return positions, speeds
