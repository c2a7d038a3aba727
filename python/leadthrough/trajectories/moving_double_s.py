"""The phases of a double S between moving states without acceleration.

The speed goes to a peak, stays there and goes to its last value, each by a ramp of bounded
acceleration and jerk. The peak is not below both speeds, or not above both. Over a short way there
can be several such moves: the fastest is taken.

Source: Biagiotti and Melchiorri 2008, section 3.4; for velocities of either sign, ours.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from leadthrough.check import Float64Array

# Duration and value of the highest derivative.
Phases: TypeAlias = list[tuple[float, float]]

# Peaks among which changes of sign are looked for, closer to each other near the ends' speeds.
_TRIED = 65
# What is looked for may be as small as numbers are: its relative digits are bounded alone.
_EXACT = 1e-300


def moving_double_s(
    length: float, first: float, last: float, limits: tuple[float, float, float]
) -> Phases:
    """Durations and jerks of the fastest move over a length from one speed to another."""
    found = [
        *_over_a_peak(length, first, last, limits),
        *(_mirrored(each) for each in _over_a_peak(-length, -first, -last, limits)),
    ]
    return min(found, key=lambda phases: sum(duration for duration, _ in phases))


def _over_a_peak(
    length: float, first: float, last: float, limits: tuple[float, float, float]
) -> list[Phases]:
    """The moves whose peak is at least both speeds; there may be none."""
    from scipy.optimize import brentq

    v, a, j = limits

    lowest = max(first, last)

    def missing(above: float) -> float:
        return length - float(_covered(np.array([above]), first, last, a, j)[0])

    if missing(v - lowest) >= 0.0:
        return [_phases((first, last), v - lowest, missing(v - lowest) / v, a=a, j=j)]
    tried = (v - lowest) * np.linspace(0.0, 1.0, _TRIED) ** 2
    left = length - _covered(tried, first, last, a, j)
    changes = np.flatnonzero((left[:-1] >= 0.0) != (left[1:] >= 0.0))
    roots = [
        float(brentq(missing, tried[i], tried[i + 1], xtol=_EXACT, rtol=8.9e-16)) for i in changes
    ]
    return [_phases((first, last), above, 0.0, a=a, j=j) for above in roots]


def _covered(above: Float64Array, first: float, last: float, a: float, j: float) -> Float64Array:
    """The way covered by the two ramps over each peak, whose mean speeds are their middles."""
    lowest = max(first, last)
    total = np.zeros(len(above))
    for end in (first, last):
        change = above + (lowest - end)
        taken = np.where(change * j < a * a, 2.0 * np.sqrt(change / j), change / a + a / j)
        total += (end + 0.5 * change) * np.where(change > 0.0, taken, 0.0)
    return total


def _phases(
    ends: tuple[float, float], above: float, cruise: float, *, a: float, j: float
) -> Phases:
    up, down = (ramp(above + (max(ends) - end), a, j) for end in ends)
    return [
        (up[0], j),
        (up[1], 0.0),
        (up[0], -j),
        (cruise, 0.0),
        (down[0], -j),
        (down[1], 0.0),
        (down[0], j),
    ]


def ramp(change: float, a: float, j: float) -> tuple[float, float]:
    """Durations of the jerk and of the full acceleration for a change of speed."""
    if change * j < a * a:
        return math.sqrt(max(change, 0.0) / j), 0.0
    return a / j, change / a - a / j


def _mirrored(phases: Phases) -> Phases:
    return [(duration, -value) for duration, value in phases]
