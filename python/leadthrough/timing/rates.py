"""Rates of the joints along a path: their limits, and the speeds that they could come to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, LimitsInfeasible

# Joints that move by less, rad or m, are at rest: fitting a constant leaves as much. Where all move
# by little, those are at rest that move by less than this fraction of the most.
AT_REST = 1e-9
_FRACTION_AT_REST = 1e-3


@dataclass(frozen=True, eq=False)
class Rates:
    """Limits (joints,) along a path; zero for joints at rest."""

    velocity: Float64Array  # rad/s (m/s)
    acceleration: Float64Array  # rad/s^2 (m/s^2)
    jerk: Float64Array  # rad/s^3 (m/s^3)
    scale: Float64Array


def rates_within(limits: JointLimits, spread: Float64Array) -> Rates:
    """The rates along a path."""
    velocity, acceleration, jerk = limits.velocity, limits.acceleration, limits.jerk
    assert acceleration is not None
    assert jerk is not None
    # An infinite limit times no spread would be no number.
    some = np.maximum(spread, np.finfo(np.float64).tiny)
    # A joint that starts and stops within its spread comes to no higher speed than these.
    scale = np.minimum(
        np.minimum(velocity, np.sqrt(acceleration * some)), np.cbrt(jerk) * np.cbrt(some) ** 2
    )
    moves = spread > min(AT_REST, _FRACTION_AT_REST * spread.max())
    for i in np.flatnonzero(moves & ~(scale > 0.0)):
        name = limits.joint_names[i]
        raise LimitsInfeasible(f"{name} moves along the path, but a limit of it is 0", joint=name)
    if not np.isfinite(scale[moves]).any():
        raise InvalidInput("limits: expected a finite limit of some joint that moves, got none")
    bound = (scale > 0.0) & (spread > 0.0)
    return Rates(
        velocity=np.where(bound, velocity, 0.0),
        acceleration=np.where(bound, acceleration, 0.0),
        jerk=np.where(bound, jerk, 0.0),
        scale=np.where(moves & np.isfinite(scale), scale, 0.0),
    )
