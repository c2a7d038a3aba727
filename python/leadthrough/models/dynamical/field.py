"""Dynamical systems: a velocity everywhere, an energy that falls, and their trajectories.

Columns are normalised: the goal is 0, the demonstrations lie about in the unit ball, and the time
is in durations of the demonstrations. A system converges to its goal only asymptotically: from a
twentieth of the motion's size on, a motion is continued to rest there by the quintic that begins
with its velocity and acceleration.

Source: Bogacki and Shampine 1989, "A 3(2) pair of Runge-Kutta formulas".
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly, CubicHermiteSpline

from leadthrough.check import Float64Array, Frozen, NoPath, ShortRepr

# Error of a step: a ten-thousandth of the distance from the goal, as valleys of an energy, which
# trajectories slide along, become as narrow as they are near.
_TOLERANCE, _NEAREST = 1e-4, 0.01
# Steps, in durations of the demonstrations; a step changes by at most these factors.
_FIRST, _MAX_STEP = 1e-3, 0.05
_SHRINK, _GROW, _SAFETY = 0.2, 4.0, 0.9
_MAX_STEPS = 20_000
# Sizes of the motion beyond which a trajectory is lost.
MAX_DISTANCE = 1e3
# Distances from the goal at which a trajectory has arrived, and at which a motion's last piece
# begins, in sizes of the motion.
NEAR, _LAST = 0.01, 0.05
# Time after which it is given up, in durations of the demonstrations.
MAX_DURATION = 100.0
# The last piece takes this many times as long as at the speed with which it begins, as the end of a
# minimum-jerk motion does; and at most this much, in durations.
_SLOWING, _MAX_ENDING = 2.7, 0.25
# Deviation of starts about the demonstrations' samples, in sizes of the motion.
_ABOUT = 0.05
# Points of the grid on which other places of rest are looked for, at most.
_GRID = 40_000
# A system is at rest where it moves slower than this, in sizes per duration and size of distance.
_AT_REST = 1e-3


class Field(Frozen, ABC):
    """A system whose trajectories all end at 0: x' = f(x) with a falling energy V(x)."""

    name: ClassVar[str]  # of this kind of system in files

    @property
    @abstractmethod
    def size(self) -> int:
        """Number d of columns."""

    @abstractmethod
    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""

    @abstractmethod
    def energy(self, states: Float64Array) -> Float64Array:
        """Energies (n,) of states (n, s): 0 at the goal, positive elsewhere."""

    @abstractmethod
    def power(self, states: Float64Array) -> Float64Array:
        """Derivatives (n,) of the energy along the trajectories through states (n, s)."""

    def states(self, x: Float64Array) -> Float64Array:
        """Initial states (n, s) of motions from positions (n, d)."""
        return x

    def pushed_states(
        self,
        x: Float64Array,
        rng: np.random.Generator,  # noqa: ARG002 - of velocities, where states have one
    ) -> Float64Array:
        """States (n, s) at positions (n, d) after a push."""
        return self.states(x)

    def rate(self, states: Float64Array) -> Float64Array:
        """Derivatives (n, s) of states (n, s); the first d columns of a state are the position."""
        return self.velocity(states)

    @abstractmethod
    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The system with these arrays."""


@dataclass(frozen=True, eq=False)
class StoredArrays(ShortRepr):
    """Base of dataclasses of arrays, which files hold by the names of the fields."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        return cls(*(arrays[each.name] for each in fields(cls)))


def squared_distances(x: Float64Array, centres: Float64Array) -> Float64Array:
    """Squared distances (n, k) of positions (n, d) from centres (k, d)."""
    mixed = x @ centres.T
    squared = (x**2).sum(axis=1)[:, None] - 2.0 * mixed + (centres**2).sum(axis=1)
    return np.asarray(np.maximum(squared, 0.0))


@dataclass(frozen=True, eq=False)
class GoalTrajectory(ShortRepr):
    """A trajectory from a start to rest at the goal."""

    times: Float64Array
    positions: Float64Array  # positions (n, d) there
    velocities: Float64Array  # velocities (n, d) there

    @property
    def duration(self) -> float:
        """In durations of the demonstrations."""
        return float(self.times[-1])

    def at(self, phases: Float64Array) -> Float64Array:
        """Positions (n, d) at fractions (n,) of the duration."""
        spline = CubicHermiteSpline(self.times, self.positions, self.velocities)
        return np.asarray(spline(phases * self.duration))


@dataclass(frozen=True, eq=False)
class Endpoints(ShortRepr):
    """Last states of many trajectories."""

    times: Float64Array  # when each one (m,) arrived or was given up
    states: Float64Array  # states (m, s) there
    arrived: NDArray[np.bool_]  # whether each one (m,) came as near to the goal as asked
    falling: NDArray[np.bool_]  # whether the energy of each one (m,) fell at every sample


@dataclass(frozen=True, eq=False)
class StabilityReport(ShortRepr):
    """Results of a system's trajectories from many starts.

    Attributes:
        starts: number of starts.
        arrived: number that came within 1 % of the motion's size of the goal; of a system with
            momentum, after a push at the start and to rest there: slower than that per duration.
        rising: number whose energy did not fall at one of their samples.
        resting: number of points of a fine grid, away from the goal, at which the system is nearly
            at rest.
        longest: longest time of a trajectory, in durations of the demonstrations.
        lost: up to ten starts (m, d), normalised, that did not arrive.
    """

    starts: int
    arrived: int
    rising: int
    resting: int
    longest: float
    lost: Float64Array

    @property
    def violations(self) -> int:
        """Starts that did not arrive, increasing energies and spurious equilibria."""
        return self.starts - self.arrived + self.rising + self.resting

    @property
    def ok(self) -> bool:
        """Whether there is no violation."""
        return self.violations == 0


def _rollout(field: Field, start: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Times (n,), positions and velocities (n, d) from a position (d,) until near the goal."""
    times: list[float] = []
    states: list[Float64Array] = []
    rates: list[Float64Array] = []
    begun = field.states(start[None])
    for time, state, rate in _steps(
        field, begun, columns=len(start), near=_LAST, longest=MAX_DURATION
    ):
        if not times or time[0] > times[-1]:  # otherwise the step was refused
            times.append(float(time[0]))
            states.append(state[0].copy())
            rates.append(rate[0].copy())
    d, x = len(start), np.array(states)
    # A state of second order holds the velocities.
    return np.array(times), x[:, :d], x[:, d:] if x.shape[1] > d else np.array(rates)[:, :d]


def endpoints(
    field: Field, state: Float64Array, *, columns: int, near: float, longest: float
) -> Endpoints:
    """Last states of the trajectories from states (m, s), and whether their energies fell."""
    falling, time = np.ones(len(state), dtype=bool), np.zeros(len(state))
    for now, states, _ in _steps(field, state, columns=columns, near=near, longest=longest):
        moved = np.flatnonzero(now > time)
        falling[moved] &= field.power(states[moved]) < 0.0
        time, state = now.copy(), states
    return Endpoints(time, state.copy(), _near(state, columns, near), falling)


def advanced(field: Field, x: Float64Array, span: float) -> Float64Array:
    """Positions (m, d) that trajectories from positions (m, d) reach within a time."""
    d, first = x.shape[1], min(span, _MAX_STEP)
    begun = field.states(x)
    *_, (_, states, _) = _steps(field, begun, columns=d, near=0.0, longest=span, first=first)
    return np.asarray(states[:, :d])


def goal_trajectory(field: Field, start: Float64Array) -> GoalTrajectory:
    """The trajectory from a start (d,) to rest at the goal, 0."""
    begun, x, v = _rollout(field, start)
    if np.linalg.norm(x[-1]) > _LAST:
        raise NoPath(
            f"start: the goal was not reached in {MAX_DURATION:.0f} times the duration of the "
            "demonstrations; start nearer to them, or check the skill's stability",
            reason="not_reached",
        )
    times, ending, slopes = _ending(begun, x, v)
    return GoalTrajectory(
        np.concatenate([begun, begun[-1] + times]),
        np.concatenate([x, ending]),
        np.concatenate([v, slopes]),
    )


def _ending(
    times: Float64Array, x: Float64Array, v: Float64Array
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Times (m,), positions and velocities (m, d) of the last piece, without its begin."""
    distance, speed = float(np.linalg.norm(x[-1])), float(np.linalg.norm(v[-1]))
    if distance == 0.0:
        return np.full(1, 1e-6), np.zeros((1, x.shape[1])), np.zeros((1, x.shape[1]))
    long = min(_SLOWING * distance / max(speed, 1e-12), _MAX_ENDING)
    bend = np.zeros(x.shape[1])
    if len(times) > 1:
        bend = (v[-1] - v[-2]) / (times[-1] - times[-2])
        bend *= min(1.0, speed / long / max(float(np.linalg.norm(bend)), 1e-12))
    rest = np.zeros(x.shape[1])
    piece = BPoly.from_derivatives([0.0, long], [[x[-1], v[-1], bend], [rest, rest, rest]])
    inside = np.linspace(0.0, long, 9)[1:]
    positions = np.asarray(piece(inside))
    positions[-1] = 0.0
    return inside, positions, np.asarray(piece.derivative()(inside))


def stability_report(
    field: Field, positions: Float64Array, count: int, around: float, rng: np.random.Generator
) -> StabilityReport:
    low, high = positions.min(axis=0), positions.max(axis=0)
    lower, upper = low - around * (high - low), high + around * (high - low)
    half = count // 2
    about = positions[rng.integers(len(positions), size=half)]
    starts = np.concatenate(
        [
            about + _ABOUT * rng.standard_normal(about.shape),
            rng.uniform(lower, upper, (count - half, positions.shape[1])),
        ]
    )
    begun = field.pushed_states(starts, rng)
    reached = endpoints(field, begun, columns=begun.shape[1], near=NEAR, longest=MAX_DURATION)
    return StabilityReport(
        count,
        int(reached.arrived.sum()),
        int((~reached.falling).sum()),
        _resting(field, lower, upper, rng),
        float(reached.times.max()),
        starts[~reached.arrived][:10],
    )


def _resting(
    field: Field, lower: Float64Array, upper: Float64Array, rng: np.random.Generator
) -> int:
    """Points of a grid over a box, or of as many random ones in more than three dimensions."""
    d = len(lower)
    if d <= 3:
        lines = np.linspace(lower, upper, int(_GRID ** (1 / d))).T
        points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, d)
    else:
        points = rng.uniform(lower, upper, (_GRID, d))
    distance = np.linalg.norm(points, axis=1)
    away = distance > NEAR
    speed = np.linalg.norm(field.velocity(points[away]), axis=1)
    return int((speed < _AT_REST * np.minimum(distance[away], 1.0)).sum())


def _near(states: Float64Array, columns: int, near: float) -> NDArray[np.bool_]:
    return np.asarray((states[:, :columns] ** 2).sum(axis=1) <= near**2)


def _steps(
    field: Field,
    begun: Float64Array,
    *,
    columns: int,
    near: float,
    longest: float,
    first: float = _FIRST,
) -> Iterator[tuple[Float64Array, Float64Array, Float64Array]]:
    """Times, states (m, s) and rates after every round of steps, until `columns` are near 0."""
    size, states = field.size, begun.copy()
    times = np.zeros(len(begun))
    steps = np.full(len(begun), first)
    rates = field.rate(states)
    yield times, states, rates
    going = np.flatnonzero(~_near(states, columns, near))
    for _ in range(_MAX_STEPS):
        if len(going) == 0:
            return
        long = np.minimum(steps[going], longest - times[going])
        here, slope, h = states[going], rates[going], long[:, None]
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
        times[taken] += long[good]
        states[taken], rates[taken] = there[good], last[good]
        change = _SAFETY / np.cbrt(np.maximum(ratio, 1e-9))
        steps[going] = np.minimum(long * np.clip(change, _SHRINK, _GROW), _MAX_STEP)
        yield times, states, rates
        on_way = ~_near(states[going], columns, near) & (times[going] < longest)
        on_way &= _near(states[going], size, MAX_DISTANCE)
        going = going[on_way]
