"""Straight moves: trapezoids of velocity, and the double S with bounded jerk.

Several dimensions move along a straight line and arrive together; the one nearest its limits sets
the pace. A move that would arrive too early or too fast goes past its end or back before its start.

Source: Biagiotti and Melchiorri 2008, sections 3.2 and 3.4; for velocities of either sign, ours.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories.curve import Spline

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
        InvalidInput: if nothing is to move, or a velocity is not along the line or not within its
            limit.
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

    It begins and ends without acceleration. Arguments and errors are as of `trapezoid`.
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
    given = check.array(rate, name, shape=() if check.rank(rate) == 0 else (size,))
    if given.ndim == 0 and size > 1 and given != 0.0:
        raise InvalidInput(f"{name}: expected a velocity ({size},) or 0, got {given}")
    return np.broadcast_to(given, (size,))


def _along(rate: ArrayLike, name: str, way: Float64Array, limit: float) -> float:
    """A velocity as a rate of the fraction of the way."""
    row = _row(rate, name, len(way))
    found = float(row @ way / (way @ way))
    if np.abs(row - found * way).max() > _ON_THE_LINE * np.abs(row).max():
        raise check.refused(name, f"a velocity along the line from start to end, {way}", row)
    if abs(found) > limit * (1.0 + _ON_THE_LINE):
        raise check.refused(
            name, f"at most the limit of the velocity, {limit / abs(found):.3g} of it", row
        )
    return min(max(found, -limit), limit)


def _scalar(limit: ArrayLike, name: str, way: Float64Array) -> float:
    """The limit on the rate of the fraction of the way such that every dimension keeps its own."""
    row = check.row(limit, name, width=len(way))
    if (row <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {row.min()}")
    moved = way != 0.0
    return float((row[moved] / np.abs(way[moved])).min())


def _straight(
    x: Float64Array, way: Float64Array, phases: Phases, *, order: int, rate: float = 0.0
) -> Spline:
    """A move whose derivative of an order is constant in each phase; it begins at a rate."""
    total = sum(duration for duration, _ in phases)
    if not math.isfinite(total):
        raise InvalidInput("velocity, acceleration: the limits are so low that no motion ends")
    factorials = np.array([math.factorial(k) for k in range(order + 1)], dtype=np.float64)
    state, knots, rows = np.zeros(order), [0.0], []
    state[1] = rate
    for duration, value in phases:
        if duration <= _NO_PHASE * total:
            continue
        derivatives = np.append(state, value)
        rows.append(derivatives / factorials)
        knots.append(knots[-1] + duration)
        state = np.array(
            [
                np.polyval((derivatives[k:] / factorials[: order + 1 - k])[::-1], duration)
                for k in range(order)
            ]
        )
    table = np.array(rows)[:, :, None] * way
    table[:, 0] += x
    return Spline(np.array(knots), table)


# Duration and value of the highest derivative.
Phases: TypeAlias = list[tuple[float, float]]

# Peaks among which changes of sign are looked for, closer to each other near the ends' speeds.
_TRIED = 65
# A root may be as small as numbers are: its relative digits are bounded alone.
_EXACT = 1e-300


def moving_double_s(
    length: float, first: float, last: float, limits: tuple[float, float, float]
) -> Phases:
    """Durations and jerks of the fastest move over a length from one speed to another."""
    back = _over_a_peak(-length, -first, -last, limits)
    mirrored = [[(duration, -value) for duration, value in phases] for phases in back]
    found = [*_over_a_peak(length, first, last, limits), *mirrored]
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
    rising = [(up[0], j), (up[1], 0.0), (up[0], -j)]
    brake = [(down[0], -j), (down[1], 0.0), (down[0], j)]
    return [*rising, (cruise, 0.0), *brake]


def ramp(change: float, a: float, j: float) -> tuple[float, float]:
    """Durations of the jerk and of the full acceleration for a change of speed."""
    if change * j < a * a:
        return math.sqrt(max(change, 0.0) / j), 0.0
    return a / j, change / a - a / j
