"""Chunks of commands as they come, put on a guard's clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event
from leadthrough.motion import JointTrajectory

_SAME_PERIOD = 1e-6  # relative; clocks that differ by less are one


@dataclass(frozen=True, eq=False)
class Chunk:
    """Samples a period apart."""

    rows: Float64Array  # (n, joints), perhaps not finite
    start: float  # time of the first one on the chunk's own clock, s
    given: JointTrajectory | None = None
    events: tuple[Event, ...] = ()  # of it
    resampled: bool = False  # whether its clock was another


def chunk_of(value: JointTrajectory | ArrayLike, arm: Arm, period: float) -> Chunk:
    """A user's chunk."""
    if not isinstance(value, JointTrajectory):
        rows = check.with_gaps(value, "chunk", shape=("n", len(arm.joint_names)))
        if not len(rows):
            raise InvalidInput("chunk: expected at least one sample, got none")
        return Chunk(np.array(rows), period)
    own = _own(value, arm)
    start = float(own.times[0])
    steps = np.diff(own.times)
    if (np.abs(steps - period) <= _SAME_PERIOD * period + 1e-12 * np.abs(own.times[1:])).all():
        return Chunk(own.positions, start, own, own.events)
    count = 1 + int(np.floor((own.times[-1] - start) / period * (1.0 + 1e-9)))
    at = np.minimum(start + period * np.arange(count), own.times[-1])
    return Chunk(_interpolated(own, at), start, None, own.events, resampled=True)


def _own(value: JointTrajectory, arm: Arm) -> JointTrajectory:
    if value.joint_names in ((), arm.joint_names) and value.positions.shape[1] == len(
        arm.joint_names
    ):
        return value
    return arm.joints_of(value)


def _interpolated(own: JointTrajectory, at: Float64Array) -> Float64Array:
    """Positions at times, along a smooth curve through the samples."""
    from scipy.interpolate import CubicHermiteSpline, CubicSpline

    if len(own.times) == 1:
        return np.repeat(own.positions, len(at), axis=0)
    if own.velocities is not None:
        return np.asarray(CubicHermiteSpline(own.times, own.positions, own.velocities)(at))
    return np.asarray(CubicSpline(own.times, own.positions, bc_type="natural")(at))
