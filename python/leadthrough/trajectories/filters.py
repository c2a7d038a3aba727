"""Filters that lead a reference to targets as these arrive, one step a sample.

A filter is frozen; what changes is its FilterState, which goes into `step` and comes out of it. A
target (d,) is where it is one period later; a period is 1e-7 to 1e5 s. Linear filters are stepped
exactly. Every dimension is filtered by itself, but for the StraightFilter.

The JerkFilter ramps towards its highest velocity for as long as a stop begun afterwards would end
before the target; then it stops. It needs the present state only; each motion is time-optimal. A
state outside the limits returns inside them as fast as it may.

Source: Grioli 2023, chapter 3; Zanasi, Lo Bianco and Tonielli 2000, time-optimal filters; Castain
and Paul 1984, "An on-line dynamic trajectory generator", for the JerkFilter.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr

# A target this near, relative to the size of the numbers, is reached: nearer is rounding.
_REACHED = 1e-14
# s; steps outside this range lose their digits.
_MIN_PERIOD, _MAX_PERIOD = 1e-7, 1e5


@dataclass(frozen=True, eq=False)
class FilterState(ShortRepr):
    """Position, velocity and acceleration of a reference; read-only copies.

    Filters that do not bound the jerk return the mean acceleration of the last step, and need none.

    Attributes:
        position: (d,).
        velocity: per second, (d,).
        acceleration: per second squared, (d,).
    """

    position: Float64Array
    velocity: Float64Array
    acceleration: Float64Array

    def __post_init__(self) -> None:
        x = check.frozen(self.position, "position", shape=("d",))
        rates = {
            name: check.frozen(getattr(self, name), name, shape=x.shape)
            for name in ("velocity", "acceleration")
        }
        vars(self).update(position=x, **rates)

    @staticmethod
    def at_rest(position: ArrayLike) -> FilterState:
        """At rest at a position.

        Args:
            position: (d,).
        """
        x = check.frozen(position, "position", shape=("d",))
        return _computed(x, np.zeros_like(x), np.zeros_like(x))


def _computed(
    position: Float64Array, velocity: Float64Array, acceleration: Float64Array
) -> FilterState:
    return check.computed(
        FilterState, position=position, velocity=velocity, acceleration=acceleration
    )


class LinearFilter(ShortRepr, ABC):
    """A filter whose distance from its target follows a linear equation, solved exactly."""

    def step(
        self,
        state: FilterState,
        target: ArrayLike,
        period: float,
        *,
        velocity: ArrayLike = 0.0,
    ) -> FilterState:
        """The state one period later.

        Args:
            velocity: the target's, (d,) or one number; with it a moving target is followed without
                lag.
        """
        x, goal, speed, dt = _inputs(state, target, velocity, period)
        lag, moved, change = self._moved(x - goal + speed * dt, state.velocity, speed, dt)
        return _computed(goal + lag, moved, change)

    @abstractmethod
    def _moved(
        self, lag: Float64Array, velocity: Float64Array, speed: Float64Array, dt: float
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Distance from the target, velocity and acceleration after a step."""


@dataclass(frozen=True)
class FirstOrderFilter(LinearFilter):
    """A reference whose distance from its target decays exponentially.

    Attributes:
        rate: of the decay, 1/s, > 0.
    """

    rate: float

    def __post_init__(self) -> None:
        check.number(self.rate, "rate", above=0.0)

    def _moved(
        self, lag: Float64Array, velocity: Float64Array, speed: Float64Array, dt: float
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        left = lag * math.exp(-self.rate * dt)
        moved = speed - self.rate * left
        return left, moved, (moved - velocity) / dt


@dataclass(frozen=True)
class SecondOrderFilter(LinearFilter):
    """A reference tied to its target by a spring and a damper.

    Attributes:
        stiffness: 1/s^2, > 0.
        damping: 1/s, > 0.
    """

    stiffness: float
    damping: float

    def __post_init__(self) -> None:
        check.number(self.stiffness, "stiffness", above=0.0)
        check.number(self.damping, "damping", above=0.0)

    def _moved(
        self, lag: Float64Array, velocity: Float64Array, speed: Float64Array, dt: float
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        slip = velocity - speed
        a, b, c, d = self._transition(dt)
        left, slip = a * lag + b * slip, c * lag + d * slip
        return left, speed + slip, -self.stiffness * left - self.damping * slip

    def _transition(self, dt: float) -> tuple[float, float, float, float]:
        """The matrix exponential of [[0, 1], [-stiffness, -damping]] dt."""
        half = 0.5 * self.damping
        root = complex(half**2 - self.stiffness) ** 0.5
        angle = root * dt
        # exp(-half dt) cosh and sinh / root, without an overflow of either factor.
        up, down = np.exp(angle - half * dt), np.exp(-angle - half * dt)
        cosh = float((0.5 * (up + down)).real)
        sinh = float(((up - down) / (2.0 * root)).real) if abs(angle) > 1e-8 else dt * cosh
        return cosh + half * sinh, sinh, -self.stiffness * sinh, cosh - half * sinh


@dataclass(frozen=True, eq=False, init=False)
class TimeOptimalFilter(ShortRepr):
    """Time-optimal motion to a target, at rest or moving, within velocity and acceleration limits.

    The bang-bang law of the phase plane chatters when sampled; this is its sampled form. From the
    speed v towards the target, equal steps of at most a T bring the reference to rest in k periods
    T over a distance v T k / 2, if v <= k a T. The next speed is the largest from which it can
    still come to rest in this way before the target: with the distance B = X - w T / 2 that is left
    when the present speed w has run out, v = max over k of min(k a T, 2 B / ((k + 1) T)). A step
    later v (k - 1) / k is such a speed again, so that no step passes the target or brakes harder,
    and the last one, with k = 1, ends at rest on it. If the reference is too fast for its
    target, it brakes as hard as it may. Of a target that moves at a constant velocity the same
    holds in its frame, where the limit of the velocity is another one either way.

    Attributes:
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.
    """

    velocity: Float64Array
    acceleration: Float64Array

    def __init__(self, velocity: ArrayLike, acceleration: ArrayLike) -> None:
        vars(self).update(
            velocity=rate_limit(velocity, "velocity"),
            acceleration=rate_limit(acceleration, "acceleration"),
        )

    def step(
        self,
        state: FilterState,
        target: ArrayLike,
        period: float,
        *,
        velocity: ArrayLike = 0.0,
    ) -> FilterState:
        """The state one period later.

        Args:
            velocity: the target's, (d,) or one number; a moving target within the limits is caught
                and then followed without lag.
        """
        x, goal, drift, dt = _inputs(state, target, velocity, period)
        top = limit_for(self.velocity, "velocity", x)
        push = limit_for(self.acceleration, "acceleration", x)
        # All speeds are relative to the target, towards where it is now.
        away = goal - drift * dt - x
        side = np.where(away >= 0.0, 1.0, -1.0)
        distance, speed = np.abs(away), side * (state.velocity - drift)
        change = push * dt
        room = np.maximum(distance - 0.5 * speed * dt, 0.0)
        periods = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * room / (change * dt)) - 1.0))
        best = np.maximum(periods * change, 2.0 * room / ((periods + 2.0) * dt))
        # With limits just lowered the speed may be above the top: it falls as fast as it may.
        slowest = speed - change
        fastest = np.maximum(slowest, np.minimum(speed + change, top - side * drift))
        # A target beyond the limit overtakes: behind it already, too, no faster than the limit.
        chosen = np.clip(np.maximum(best, -top - side * drift), slowest, fastest)
        moved = x + side * 0.5 * (speed + chosen) * dt + drift * dt
        rests = (np.abs(goal - moved) <= _REACHED * (np.abs(goal) + np.abs(x))) & (
            np.abs(chosen) <= 1e-9 * change
        )
        reached = np.where(rests, 0.0, side * chosen) + drift
        return _computed(np.where(rests, goal, moved), reached, (reached - state.velocity) / dt)


def _inputs(
    state: FilterState, target: ArrayLike, velocity: ArrayLike, period: float
) -> tuple[Float64Array, Float64Array, Float64Array, float]:
    check.instance(state, "state", FilterState)
    x = state.position
    goal = check.array(target, "target", shape=(len(x),))
    return x, goal, check.row(velocity, "velocity", width=len(x)), check_period(period)


def check_period(period: float) -> float:
    """`period` as a number of seconds that filters can step by."""
    return check.number(period, "period", at_least=_MIN_PERIOD, at_most=_MAX_PERIOD)


def rate_limit(value: ArrayLike, name: str) -> Float64Array:
    """A limit > 0, (d,) or one number for all dimensions, read-only."""
    limit = check.frozen(value, name, shape=() if check.rank(value) == 0 else ("d",))
    if (limit <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {limit.min()}")
    return limit


def limit_for(limit: Float64Array, name: str, x: Float64Array) -> Float64Array:
    """A checked limit, (d,), for every dimension of x (d,)."""
    if limit.ndim and limit.shape != x.shape:
        raise InvalidInput(f"{name}: expected limits of {len(x)} dimensions, got {len(limit)}")
    return np.broadcast_to(limit, x.shape)


# Beyond this, sums of cubes lose all digits.
_MAX_NUMBER = 1e12


@dataclass(frozen=True, eq=False, init=False)
class JerkFilter(ShortRepr):
    """Time-optimal motion to a target within limits of velocity, acceleration and jerk.

    Each limit is > 0, (d,) or one number for all dimensions. The motion ends at rest relative to
    the target, which may move: of one that moves at a constant velocity, the same law holds in its
    frame, where the limits of the velocity are others. A filter with other limits goes on from any
    state.

    Attributes:
        velocity: limit in the positive direction.
        acceleration: limit in the positive direction.
        jerk: limit in the positive direction.
        velocity_down: limit in the negative direction, by default the same.
        acceleration_down: limit in the negative direction, by default the same.
        jerk_down: limit in the negative direction, by default the same.

    Raises:
        InvalidInput: if a limit is above 1e12.
    """

    velocity: Float64Array
    acceleration: Float64Array
    jerk: Float64Array
    velocity_down: Float64Array
    acceleration_down: Float64Array
    jerk_down: Float64Array
    _limits: Float64Array = field(init=False, repr=False)  # (6, d or 1) low and high of each rate

    def __init__(  # noqa: PLR0917  # its fields, in their order
        self,
        velocity: ArrayLike,
        acceleration: ArrayLike,
        jerk: ArrayLike,
        velocity_down: ArrayLike | None = None,
        acceleration_down: ArrayLike | None = None,
        jerk_down: ArrayLike | None = None,
    ) -> None:
        limits = {}
        for name, up, down in zip(
            ("velocity", "acceleration", "jerk"),
            (velocity, acceleration, jerk),
            (velocity_down, acceleration_down, jerk_down),
            strict=True,
        ):
            limits[f"{name}_down"] = rate_limit(up if down is None else down, f"{name}_down")
            limits[name] = rate_limit(up, name)
        vars(self).update(limits, _limits=_table(limits))

    def step(
        self,
        state: FilterState,
        target: ArrayLike,
        period: float,
        *,
        velocity: ArrayLike = 0.0,
    ) -> FilterState:
        """The state one period later, each dimension time-optimal by itself.

        Args:
            target: (d,), one period later.
            velocity: the target's, (d,) or one number; with it a moving target is caught and then
                followed without lag. One beyond the limits is chased at them.
        """
        return self._stepped(core.step_each, state, target, period, velocity)

    def step_together(
        self,
        state: FilterState,
        target: ArrayLike,
        period: float,
        *,
        velocity: ArrayLike = 0.0,
    ) -> FilterState:
        """The state one period later; all dimensions arrive when the slowest of them can.

        The others keep a lower speed on their way. Only one whose hardest stop happens to end on
        its target cannot wait, and arrives earlier.

        Args:
            target: as for `step`.
            velocity: as for `step`.
        """
        return self._stepped(core.step_together, state, target, period, velocity)

    def durations(
        self, state: FilterState, target: ArrayLike, *, velocity: ArrayLike = 0.0
    ) -> Float64Array:
        """Times (d,), s, that `step` takes to the target.

        Args:
            target: (d,), now.
            velocity: the target's, (d,) or one number.
        """
        states, limits, goal = self._checked(state, target)
        drift = self.followed(velocity, len(goal))
        return np.asarray(core.times_to_rest(*_relative(states, limits, drift), goal))

    def resting_place(self, state: FilterState) -> Float64Array:
        """Positions (d,) at which the dimensions rest after the fastest stop."""
        states, limits, _ = self._checked(state, getattr(state, "position", ()))
        return np.asarray(core.resting_places(states, limits))

    def along(self, direction: ArrayLike) -> JerkFilter:
        """The filter of a position on a line, such that all dimensions keep their limits.

        Args:
            direction: of the line, (d,); a dimension that does not move does not bind.
        """
        u = check.array(direction, "direction", shape=("d",))
        if not u.any():  # nothing moves: any limit will do
            return JerkFilter(1.0, 1.0, 1.0)
        limits = self._limits_of(len(u)).reshape(3, 2, len(u))  # rate, low and high, dimension
        with np.errstate(divide="ignore"):
            along = np.abs(limits / u)
        along[:, :, u == 0.0] = np.inf
        forwards = np.where(u > 0.0, along[:, 1], along[:, 0]).min(axis=1)
        backwards = np.where(u > 0.0, along[:, 0], along[:, 1]).min(axis=1)
        return JerkFilter(*forwards, *backwards)

    def followed(self, velocity: ArrayLike, dimensions: int) -> Float64Array:
        """The velocity (d,) of a target, as far as the limits let it be followed.

        Args:
            velocity: (d,) or one number.
            dimensions: d.
        """
        low, high = self._limits_of(dimensions)[:2]
        drift = check.row(velocity, "velocity", width=dimensions)
        return np.clip(drift, _BELOW_LIMIT * low, _BELOW_LIMIT * high)

    def relative_to(self, velocity: ArrayLike) -> JerkFilter:
        """The filter of what is left to a target that moves at a velocity (d,) inside the limits.

        Args:
            velocity: (d,).
        """
        drift = check.array(velocity, "velocity", shape=("d",))
        low, high, push_low, push_high, jerk_low, jerk_high = self._limits_of(len(drift))
        return JerkFilter(high - drift, push_high, jerk_high, drift - low, -push_low, -jerk_low)

    def _stepped(
        self,
        step: Callable[..., Float64Array],
        state: FilterState,
        target: ArrayLike,
        period: float,
        velocity: ArrayLike,
    ) -> FilterState:
        """One of the core's steps, in the frame of the target."""
        states, limits, goal = self._checked(state, target)
        dt = check_period(period)
        if isinstance(velocity, float) and velocity == 0.0:  # the quick way, for control loops
            return _computed(*step(states, limits, goal, dt))
        drift = self.followed(velocity, len(goal))
        moved = drift * dt
        position, rate, acceleration = step(*_relative(states, limits, drift), goal - moved, dt)
        there = (position == goal - moved) & (rate == 0.0) & (acceleration == 0.0)
        return _computed(np.where(there, goal, position + moved), rate + drift, acceleration)

    def _checked(
        self, state: FilterState, target: ArrayLike
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """States (3, d), limits (6, d), low and high, and targets (d,)."""
        check.instance(state, "state", FilterState)
        states = np.array((state.position, state.velocity, state.acceleration))
        goal = check.array(target, "target", shape=state.position.shape)
        if max(np.abs(x).max(initial=0.0) for x in (states, goal)) > _MAX_NUMBER:
            raise InvalidInput(f"state, target: expected numbers up to {_MAX_NUMBER:g}")
        return states, self._limits_of(len(goal)), goal

    def _limits_of(self, dimensions: int) -> Float64Array:
        """Limits (6, d)."""
        size = self._limits.shape[1]
        if size == dimensions:  # the quick way, for control loops
            return self._limits
        if size not in {1, dimensions}:
            raise InvalidInput(f"limits: expected limits of {dimensions} dimensions, got {size}")
        return np.ascontiguousarray(np.broadcast_to(self._limits, (6, dimensions)))


# A target at a limit is chased this little below it, so that there is speed left to come near.
_BELOW_LIMIT = 1.0 - 1e-9


def _relative(
    states: Float64Array, limits: Float64Array, drift: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """States (3, d) and limits (6, d) in a frame that moves at a velocity (d,)."""
    moved, bounds = states.copy(), limits.copy()
    moved[1] -= drift
    bounds[:2] -= drift
    return moved, bounds


def _table(limits: Mapping[str, Float64Array]) -> Float64Array:
    """Low and high bounds (6, d) of each rate; d is 1 where all limits are single numbers."""
    rows = [
        np.atleast_1d(-limit if name.endswith("_down") else limit) for name, limit in limits.items()
    ]
    sizes = {len(row) for row in rows if len(row) != 1}
    if len(sizes) > 1:
        raise InvalidInput(f"limits: expected as many of each, got {sorted(sizes)}")
    table = np.stack(np.broadcast_arrays(*rows))
    if np.abs(table).max(initial=0.0) > _MAX_NUMBER:
        raise InvalidInput(f"limits: expected numbers up to {_MAX_NUMBER:g}")
    return table
