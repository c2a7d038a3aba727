"""Straight moves from rest to rest: trapezoids of velocity, and the double S with bounded jerk.

Several dimensions move along a straight line and arrive together; the one nearest its limits sets
the pace.

Source: Biagiotti and Melchiorri 2008, sections 3.2 and 3.4.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories.spline import Spline

# A phase shorter than this, relative to the whole move, is rounding.
_NO_PHASE = 1e-12


def trapezoid(
    start: ArrayLike, end: ArrayLike, *, velocity: ArrayLike, acceleration: ArrayLike
) -> Spline:
    """The fastest straight move inside limits of velocity and acceleration: three phases.

    Args:
        start: (d,).
        end: (d,).
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.

    Raises:
        InvalidInput: if start and end are the same, the shapes do not fit or a limit is not > 0.
    """
    x, way = _move(start, end)
    v, a = _scalar(velocity, "velocity", way), _scalar(acceleration, "acceleration", way)
    ramp = min(v / a, math.sqrt(1.0 / a))
    cruise = 1.0 / (a * ramp) - ramp
    return _straight(x, way, [(ramp, a), (cruise, 0.0), (ramp, -a)], order=2)


def double_s(
    start: ArrayLike,
    end: ArrayLike,
    *,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    jerk: ArrayLike,
) -> Spline:
    """The fastest straight move inside limits of velocity, acceleration and jerk: seven phases.

    Args:
        start: (d,).
        end: (d,).
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.
        jerk: limit > 0, (d,) or one number for all dimensions.

    Raises:
        InvalidInput: if start and end are the same, the shapes do not fit or a limit is not > 0.
    """
    x, way = _move(start, end)
    v, a = _scalar(velocity, "velocity", way), _scalar(acceleration, "acceleration", way)
    j = _scalar(jerk, "jerk", way)
    rise, push = _ramp(v, a, j)
    if (2.0 * rise + push) * j * rise * (rise + push) > 1.0:  # too short for full velocity
        rise = a / j
        push = 0.5 * (math.sqrt(rise**2 + 4.0 / a) - 3.0 * rise)
        if push < 0.0:  # nor for full acceleration
            rise, push = (0.5 / j) ** (1.0 / 3.0), 0.0
    top = j * rise * (rise + push)
    cruise = max(1.0 / top - (2.0 * rise + push), 0.0)
    ramp = [(rise, j), (push, 0.0), (rise, -j)]
    brake = [(rise, -j), (push, 0.0), (rise, j)]
    return _straight(x, way, [*ramp, (cruise, 0.0), *brake], order=3)


def _ramp(v: float, a: float, j: float) -> tuple[float, float]:
    """Durations of the jerk and of the full acceleration on the way to velocity v."""
    if v * j < a * a:
        return math.sqrt(v / j), 0.0
    return a / j, v / a - a / j


def _move(start: ArrayLike, end: ArrayLike) -> tuple[Float64Array, Float64Array]:
    x = check.array(start, "start", shape=("d",))
    way = check.array(end, "end", shape=(len(x),)) - x
    if not way.any():
        raise InvalidInput(f"end: expected a point other than start, got {x} twice")
    return x, way


def _scalar(limit: ArrayLike, name: str, way: Float64Array) -> float:
    """The limit on the rate of the fraction of the way such that every dimension keeps its own."""
    row = check.array(limit, name, shape=() if np.ndim(limit) == 0 else (len(way),))
    if (row <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {row.min()}")
    moved = way != 0.0
    return float((np.broadcast_to(row, len(way))[moved] / np.abs(way[moved])).min())


def _straight(
    x: Float64Array, way: Float64Array, phases: list[tuple[float, float]], *, order: int
) -> Spline:
    """A move whose derivative of an order is constant in each phase, (duration, value)."""
    total = sum(duration for duration, _ in phases)
    state, knots, rows = np.zeros(order), [0.0], []
    for duration, value in phases:
        if duration <= _NO_PHASE * total:
            continue
        derivatives = np.append(state, value)
        row = derivatives / [math.factorial(k) for k in range(order + 1)]
        rows.append(row)
        knots.append(knots[-1] + duration)
        state = np.array(
            [
                np.polyval((derivatives[k:] / _factorials(order + 1 - k))[::-1], duration)
                for k in range(order)
            ]
        )
    table = np.array(rows)[:, :, None] * way
    table[:, 0] += x
    return Spline(np.array(knots), table)


def _factorials(count: int) -> Float64Array:
    return np.array([math.factorial(k) for k in range(count)], dtype=np.float64)
