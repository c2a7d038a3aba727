"""Many trajectories of one system at once, each with its own step.

Source: Bogacki and Shampine 1989, "A 3(2) pair of Runge-Kutta formulas".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.field import Field
from leadthrough.repr import ShortRepr

# Error of a step: a ten-thousandth of the distance from the goal, as valleys of an energy, which
# trajectories slide along, become as narrow as they are near.
_TOLERANCE, _NEAREST = 1e-4, 0.01
# Steps, in durations of the demonstrations; a step changes by at most these factors.
_FIRST, _LONGEST = 1e-3, 0.05
_SHRINK, _GROW, _SAFETY = 0.2, 4.0, 0.9
_MOST_STEPS = 20_000
# Sizes of the motion beyond which a trajectory is lost.
_FARTHEST = 1e3


@dataclass(frozen=True, eq=False)
class Course(ShortRepr):
    """One trajectory."""

    times: Float64Array  # times (n,) of its samples, from 0 on
    states: Float64Array  # states (n, s)
    rates: Float64Array  # their derivatives (n, s)


@dataclass(frozen=True, eq=False)
class Ends(ShortRepr):
    """Where many trajectories ended."""

    times: Float64Array  # when each one (m,) arrived or was given up
    states: Float64Array  # states (m, s) there
    arrived: NDArray[np.bool_]  # whether each one (m,) came as near to the goal as asked
    falling: NDArray[np.bool_]  # whether the energy of each one (m,) fell at every sample


def course(field: Field, start: Float64Array, *, near: float, longest: float) -> Course:
    """The trajectory from a position (d,) until it is near the goal."""
    times: list[float] = []
    states: list[Float64Array] = []
    rates: list[Float64Array] = []
    for time, state, rate in _steps(field, start[None], near=near, longest=longest):
        if not times or time[0] > times[-1]:  # otherwise the step was refused
            times.append(float(time[0]))
            states.append(state[0].copy())
            rates.append(rate[0].copy())
    return Course(np.array(times), np.array(states), np.array(rates))


def ends(field: Field, starts: Float64Array, *, near: float, longest: float) -> Ends:
    """Where the trajectories from positions (m, d) end, and whether their energies fell."""
    falling = np.ones(len(starts), dtype=bool)
    time, state = np.zeros(len(starts)), field.states(starts)
    for now, states, _ in _steps(field, starts, near=near, longest=longest):
        moved = np.flatnonzero(now > time)
        falling[moved] &= field.power(states[moved]) < 0.0
        time, state = now.copy(), states
    return Ends(time, state.copy(), _near(state, starts.shape[1], near), falling)


def _near(states: Float64Array, size: int, near: float) -> NDArray[np.bool_]:
    return np.asarray((states[:, :size] ** 2).sum(axis=1) <= near**2)


def _steps(
    field: Field, starts: Float64Array, *, near: float, longest: float
) -> Iterator[tuple[Float64Array, Float64Array, Float64Array]]:
    """Times (m,), states (m, s) and rates (m, s) after every round of steps, from the start on."""
    size = starts.shape[1]
    states = field.states(starts).copy()
    times = np.zeros(len(starts))
    steps = np.full(len(starts), _FIRST)
    rates = field.rate(states)
    yield times, states, rates
    going = np.flatnonzero(~_near(states, size, near))
    for _ in range(_MOST_STEPS):
        if len(going) == 0:
            return
        here, slope, h = states[going], rates[going], steps[going][:, None]
        second = field.rate(here + 0.5 * h * slope)
        third = field.rate(here + 0.75 * h * second)
        there = here + h * (2.0 * slope + 3.0 * second + 4.0 * third) / 9.0
        last = field.rate(there)
        error = h * (-5.0 / 72.0 * slope + second / 12.0 + third / 9.0 - last / 8.0)
        distance = np.sqrt((here[:, :size] ** 2).sum(axis=1))
        allowed = _TOLERANCE * np.clip(distance, _NEAREST, 1.0)
        ratio = np.abs(error).max(axis=1) / allowed
        good = ratio <= 1.0
        taken = going[good]
        times[taken] += steps[taken]
        states[taken], rates[taken] = there[good], last[good]
        change = _SAFETY / np.cbrt(np.maximum(ratio, 1e-9))
        steps[going] = np.minimum(steps[going] * np.clip(change, _SHRINK, _GROW), _LONGEST)
        yield times, states, rates
        kept = ~_near(states[going], size, near) & (times[going] < longest)
        kept &= _near(states[going], size, _FARTHEST)
        going = going[kept]
