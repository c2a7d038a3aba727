"""Straight moves from rest to rest: trapezoids of velocity, and the double S with bounded jerk.

Several dimensions move along a straight line and arrive together; the one with the least room
under its limits sets the pace. Source: Biagiotti and Melchiorri 2008, sections 3.2 and 3.4.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories.spline import Spline

# What rounding leaves of a phase that is not there, relative to the whole move.
_NO_PHASE = 1e-12


def trapezoid(start: Any, end: Any, *, velocity: Any, acceleration: Any) -> Spline:
    """The fastest straight move from start (d,) to end (d,) inside limits of rates, > 0.

    velocity, acceleration: (d,) or one number for all. Raises InvalidInput.
    """
    x, way = _move(start, end)
    v, a = _scalar(velocity, "velocity", way), _scalar(acceleration, "acceleration", way)
    ramp = min(v / a, math.sqrt(1.0 / a))
    cruise = 1.0 / (a * ramp) - ramp
    return _straight(x, way, [(ramp, a), (cruise, 0.0), (ramp, -a)], order=2)


def double_s(start: Any, end: Any, *, velocity: Any, acceleration: Any, jerk: Any) -> Spline:
    """The fastest straight move inside limits of velocity, acceleration and jerk: seven phases.

    Limits: (d,) or one number for all, > 0. Raises InvalidInput.
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
    """How long the jerk lasts on the way to velocity v, and the full acceleration."""
    if v * j < a * a:
        return math.sqrt(v / j), 0.0
    return a / j, v / a - a / j


def _move(start: Any, end: Any) -> tuple[Float64Array, Float64Array]:
    x = check.array(start, "start", shape=("d",))
    way = check.array(end, "end", shape=(len(x),)) - x
    if not way.any():
        raise InvalidInput(f"end: expected a point other than start, got {x} twice")
    return x, way


def _scalar(limit: Any, name: str, way: Float64Array) -> float:
    """The limit of the share of the way that keeps every dimension's."""
    row = check.array(limit, name, shape=() if np.ndim(limit) == 0 else (len(way),))
    if (row <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {row.min()}")
    moved = way != 0.0
    return float((np.broadcast_to(row, len(way))[moved] / np.abs(way[moved])).min())


def _straight(
    x: Float64Array, way: Float64Array, phases: list[tuple[float, float]], *, order: int
) -> Spline:
    """A move whose derivative of an order is constant in each phase: (duration, value)."""
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
