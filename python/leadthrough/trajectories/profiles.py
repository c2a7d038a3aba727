"""Straight moves: trapezoids of velocity, and the double S with bounded jerk.

Several dimensions move along a straight line and arrive together; the one nearest its limits sets
the pace. A move may begin and end with a velocity along the line; where it would arrive too early
or too fast, it goes past its end or back before its start.

Source: Biagiotti and Melchiorri 2008, sections 3.2 and 3.4.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories.moving_double_s import Phases, moving_double_s, ramp
from leadthrough.trajectories.spline import Spline

# A velocity is along a line if no more of it, relatively, points elsewhere.
_ON_THE_LINE = 1e-9
# A phase shorter than this, relative to the whole move, is rounding.
_NO_PHASE = 1e-12


def trapezoid(
    start: ArrayLike,
    end: ArrayLike,
    *,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    start_velocity: ArrayLike = 0.0,
    end_velocity: ArrayLike = 0.0,
) -> Spline:
    """The fastest straight move inside limits of velocity and acceleration: three phases.

    Args:
        start: (d,).
        end: (d,).
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.
        start_velocity: (d,) along the line from start to end, or one number for one dimension.
        end_velocity: the same at the end.

    Raises:
        InvalidInput: if nothing is to move, the shapes do not fit, a limit is not > 0, or a
            velocity is not along the line or not within its limit.
    """
    x, way, length = _move(start, end, start_velocity, end_velocity)
    v, a = _scalar(velocity, "velocity", way), _scalar(acceleration, "acceleration", way)
    first = _along(start_velocity, "start_velocity", way, v)
    last = _along(end_velocity, "end_velocity", way, v)
    if first or last:
        return _straight(x, way, _trapezoid_phases(length, first, last, v, a), order=2, rate=first)
    ramp = min(v / a, math.sqrt(1.0 / a))
    cruise = 1.0 / (a * ramp) - ramp
    return _straight(x, way, [(ramp, a), (cruise, 0.0), (ramp, -a)], order=2)


def _trapezoid_phases(length: float, first: float, last: float, v: float, a: float) -> Phases:
    """Phases (duration, acceleration) over a length from one speed to another."""
    direct = 0.5 * (last * last - first * first) / a * (1.0 if last >= first else -1.0)
    side = 1.0 if length >= direct else -1.0
    begin, end, way = side * first, side * last, side * length
    peak = math.sqrt(max(0.5 * (begin * begin + end * end) + a * way, 0.0))
    if peak > v:
        up, down = (v - begin) / a, (v - end) / a
        cruise = max((way - 0.5 * ((begin + v) * up + (v + end) * down)) / v, 0.0)
        return [(up, side * a), (cruise, 0.0), (down, -side * a)]
    up = _rise(begin, peak, 0.5 * (end * end - begin * begin) + a * way) / a
    down = _rise(end, peak, 0.5 * (begin * begin - end * end) + a * way) / a
    return [(up, side * a), (down, -side * a)]


def _rise(speed: float, peak: float, squares: float) -> float:
    """How far a speed is below a peak, of which the difference of squares is known."""
    return max(squares / (peak + speed) if speed > 0.0 else peak - speed, 0.0)


def double_s(
    start: ArrayLike,
    end: ArrayLike,
    *,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    jerk: ArrayLike,
    start_velocity: ArrayLike = 0.0,
    end_velocity: ArrayLike = 0.0,
) -> Spline:
    """The fastest straight move inside limits of velocity, acceleration and jerk: seven phases.

    It begins and ends without acceleration.

    Args:
        start: (d,).
        end: (d,).
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.
        jerk: limit > 0, (d,) or one number for all dimensions.
        start_velocity: (d,) along the line from start to end, or one number for one dimension.
        end_velocity: the same at the end.

    Raises:
        InvalidInput: if nothing is to move, the shapes do not fit, a limit is not > 0, or a
            velocity is not along the line or not within its limit.
    """
    x, way, length = _move(start, end, start_velocity, end_velocity)
    v, a = _scalar(velocity, "velocity", way), _scalar(acceleration, "acceleration", way)
    j = _scalar(jerk, "jerk", way)
    first = _along(start_velocity, "start_velocity", way, v)
    last = _along(end_velocity, "end_velocity", way, v)
    if first or last:
        phases = moving_double_s(length, first, last, (v, a, j))
        return _straight(x, way, phases, order=3, rate=first)
    rise, push = ramp(v, a, j)
    if (2.0 * rise + push) * j * rise * (rise + push) > 1.0:  # too short for full velocity
        rise = a / j
        push = 0.5 * (math.sqrt(rise**2 + 4.0 / a) - 3.0 * rise)
        if push < 0.0:  # nor for full acceleration
            rise, push = (0.5 / j) ** (1.0 / 3.0), 0.0
    top = j * rise * (rise + push)
    cruise = max(1.0 / top - (2.0 * rise + push), 0.0)
    rising = [(rise, j), (push, 0.0), (rise, -j)]
    brake = [(rise, -j), (push, 0.0), (rise, j)]
    return _straight(x, way, [*rising, (cruise, 0.0), *brake], order=3)


def _move(
    start: ArrayLike, end: ArrayLike, first: ArrayLike, last: ArrayLike
) -> tuple[Float64Array, Float64Array, float]:
    """The start, a way (d,) and how many times it leads to the end: once, or not at all."""
    x = check.array(start, "start", shape=("d",))
    way = check.array(end, "end", shape=(len(x),)) - x
    if way.any():
        return x, way, 1.0
    for rate, name in ((first, "start_velocity"), (last, "end_velocity")):
        moving = _row(rate, name, len(x))
        if moving.any():
            return x, moving, 0.0
    raise InvalidInput(f"end: expected a point other than start, got {x} twice")


def _row(rate: ArrayLike, name: str, size: int) -> Float64Array:
    """A velocity (d,); a single number is that of one dimension, or rest."""
    given = check.array(rate, name, shape=() if np.ndim(rate) == 0 else (size,))
    if given.ndim == 0 and size > 1 and given != 0.0:
        raise InvalidInput(f"{name}: expected a velocity ({size},) or 0, got {given}")
    return np.broadcast_to(given, (size,))


def _along(rate: ArrayLike, name: str, way: Float64Array, limit: float) -> float:
    """A velocity as a rate of the fraction of the way."""
    row = _row(rate, name, len(way))
    found = float(row @ way / (way @ way))
    if np.abs(row - found * way).max() > _ON_THE_LINE * np.abs(row).max():
        raise InvalidInput(
            f"{name}: expected a velocity along the line from start to end, {way}, got {row}"
        )
    if abs(found) > limit * (1.0 + _ON_THE_LINE):
        raise InvalidInput(
            f"{name}: expected at most the limit of the velocity, {limit / abs(found):.3g} of it, "
            f"got {row}"
        )
    return min(max(found, -limit), limit)


def _scalar(limit: ArrayLike, name: str, way: Float64Array) -> float:
    """The limit on the rate of the fraction of the way such that every dimension keeps its own."""
    row = check.array(limit, name, shape=() if np.ndim(limit) == 0 else (len(way),))
    if (row <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {row.min()}")
    moved = way != 0.0
    return float((np.broadcast_to(row, len(way))[moved] / np.abs(way[moved])).min())


def _straight(
    x: Float64Array, way: Float64Array, phases: Phases, *, order: int, rate: float = 0.0
) -> Spline:
    """A move whose derivative of an order is constant in each phase; it begins at a rate."""
    total = sum(duration for duration, _ in phases)
    state, knots, rows = np.zeros(order), [0.0], []
    state[1] = rate
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
