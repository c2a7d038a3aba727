"""Filters that lead a reference to targets as these arrive, one step a sample.

A filter is frozen; what changes is its FilterState, which goes into `step` and comes out of it.
Every dimension is filtered by itself. Linear filters are stepped exactly, whatever the period.

Source: Grioli 2023, chapter 3; Zanasi, Lo Bianco and Tonielli 2000 for time-optimal filters.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr

# A target this near, relative to the size of the numbers, is reached: nearer is rounding.
_REACHED = 1e-14
# s; steps outside this range lose their digits.
_SHORTEST_PERIOD, _LONGEST_PERIOD = 1e-7, 1e5


@dataclass(frozen=True, eq=False)
class FilterState(ShortRepr):
    """Position, velocity and acceleration of a reference.

    Filters that do not bound the jerk return the mean acceleration of the last step, and need none.

    Attributes:
        position: (d,).
        velocity: per second, (d,).
        acceleration: per second squared, (d,).
    """

    position: Float64Array
    velocity: Float64Array
    acceleration: Float64Array

    @staticmethod
    def at_rest(position: ArrayLike) -> FilterState:
        """At rest at a position.

        Args:
            position: (d,).

        Raises:
            InvalidInput: if it is not a finite vector.
        """
        x = check.frozen(position, "position", shape=("d",))
        return FilterState(x, np.zeros_like(x), np.zeros_like(x))


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
            state: the present one.
            target: (d,), where the target is one period later.
            period: s, 1e-7 to 1e5.
            velocity: the target's, (d,) or one number; with it a moving target is followed without
                lag.

        Raises:
            InvalidInput: if the shapes do not fit or the period is out of its range.
        """
        x, goal, speed, dt = _inputs(state, target, velocity, period)
        lag, moved, change = self._moved(x - goal + speed * dt, state.velocity, speed, dt)
        return FilterState(goal + lag, moved, change)

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

    Raises:
        InvalidInput: if the rate is not > 0.
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

    Raises:
        InvalidInput: if one of them is not > 0.
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
    """The fastest way to a target, at rest or moving, inside limits of velocity and acceleration.

    The bang-bang law of the phase plane chatters when sampled; this is its sampled form. From the
    speed v towards the target, equal steps of at most a T bring the reference to rest in k periods
    T over a distance v T k / 2, if v <= k a T. The next speed is the largest from which it can
    still come to rest in this way before the target: with the distance B = X - w T / 2 that is left
    when the present speed w has run out, v = max over k of min(k a T, 2 B / ((k + 1) T)). A step
    later v (k - 1) / k is such a speed again, so that no step passes the target or brakes harder,
    and the last one, with k = 1, ends at rest on it. Where the reference is too fast for its
    target, it brakes as hard as it may. Of a target that moves at a constant velocity the same
    holds in its frame, where the limit of the velocity is another one either way.

    Attributes:
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.

    Raises:
        InvalidInput: if a limit is not > 0.
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
            state: the present one.
            target: (d,), where the target is one period later.
            period: s, 1e-7 to 1e5.
            velocity: the target's, (d,) or one number; a moving target within the limits is caught
                and then followed without lag.

        Raises:
            InvalidInput: if the shapes do not fit or the period is out of its range.
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
        chosen = np.clip(best, slowest, fastest)
        moved = x + side * 0.5 * (speed + chosen) * dt + drift * dt
        rests = (np.abs(goal - moved) <= _REACHED * (np.abs(goal) + np.abs(x))) & (
            np.abs(chosen) <= 1e-9 * change
        )
        reached = np.where(rests, 0.0, side * chosen) + drift
        return FilterState(np.where(rests, goal, moved), reached, (reached - state.velocity) / dt)


def _inputs(
    state: FilterState, target: ArrayLike, velocity: ArrayLike, period: float
) -> tuple[Float64Array, Float64Array, Float64Array, float]:
    if not isinstance(state, FilterState):
        raise InvalidInput(f"state: expected a FilterState, got {type(state).__name__}")
    x = state.position
    goal = check.array(target, "target", shape=(len(x),))
    shape = () if np.ndim(velocity) == 0 else (len(x),)
    speed = np.broadcast_to(check.array(velocity, "velocity", shape=shape), x.shape)
    return x, goal, speed, check_period(period)


def check_period(period: float) -> float:
    """`period` as a number of seconds that filters can step by."""
    return check.number(period, "period", at_least=_SHORTEST_PERIOD, at_most=_LONGEST_PERIOD)


def rate_limit(value: ArrayLike, name: str) -> Float64Array:
    """A limit > 0, (d,) or one number for all dimensions, read-only."""
    limit = check.frozen(value, name, shape=() if np.ndim(value) == 0 else ("d",))
    if (limit <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {limit.min()}")
    return limit


def limit_for(limit: Float64Array, name: str, x: Float64Array) -> Float64Array:
    """A checked limit, (d,), for every dimension of x (d,)."""
    if limit.ndim and limit.shape != x.shape:
        raise InvalidInput(f"{name}: expected limits of {len(x)} dimensions, got {len(limit)}")
    return np.broadcast_to(limit, x.shape)
