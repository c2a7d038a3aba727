"""Filters that lead a reference to targets as these arrive, one step a sample.

A filter is frozen; what changes is its State, which goes into `step` and comes out of it. Every
dimension is filtered by itself. Linear filters are stepped exactly, whatever the period.
Source: Grioli 2023, chapter 3; Zanasi, Lo Bianco and Tonielli 2000 for time-optimal filters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# So near, relative to the size of the numbers, a target is reached: nearer is rounding.
_REACHED = 1e-14
# s; beyond them steps lose their digits.
_SHORTEST_PERIOD, _LONGEST_PERIOD = 1e-7, 1e5


@dataclass(frozen=True, eq=False)
class FilterState:
    """Where a reference is, how fast, and how fast its speed changes: (d,) each.

    Filters that bound no jerk give the mean of the last step for an acceleration, and need none.
    """

    position: Float64Array
    velocity: Float64Array
    acceleration: Float64Array

    @staticmethod
    def at_rest(position: Any) -> FilterState:
        """At rest at a position (d,). Raises InvalidInput."""
        x = check.frozen(position, "position", shape=("d",))
        return FilterState(x, np.zeros_like(x), np.zeros_like(x))


@dataclass(frozen=True)
class FirstOrderFilter:
    """A reference whose distance from its target decays at a rate, 1/s, > 0."""

    rate: float

    def __post_init__(self) -> None:
        check.number(self.rate, "rate", above=0.0)

    def step(
        self, state: FilterState, target: Any, period: float, *, velocity: Any = 0.0
    ) -> FilterState:
        """The state one period, s, on, with the target (d,) that holds then.

        velocity: the target's; with it a moving target is followed without lag.
        Raises InvalidInput.
        """
        x, goal, speed, dt = _inputs(state, target, velocity, period)
        lag = (x - goal + speed * dt) * math.exp(-self.rate * dt)
        moved = speed - self.rate * lag
        return FilterState(goal + lag, moved, (moved - state.velocity) / dt)


@dataclass(frozen=True)
class SecondOrderFilter:
    """A reference on a spring, stiffness 1/s^2 > 0, and a damper, 1/s > 0, to its target."""

    stiffness: float
    damping: float

    def __post_init__(self) -> None:
        check.number(self.stiffness, "stiffness", above=0.0)
        check.number(self.damping, "damping", above=0.0)

    def step(
        self, state: FilterState, target: Any, period: float, *, velocity: Any = 0.0
    ) -> FilterState:
        """The state one period, s, on, with the target (d,) that holds then.

        velocity: the target's; with it a moving target is followed without lag.
        Raises InvalidInput.
        """
        x, goal, speed, dt = _inputs(state, target, velocity, period)
        lag, slip = x - goal + speed * dt, state.velocity - speed
        a, b, c, d = self._transition(dt)
        lag, slip = a * lag + b * slip, c * lag + d * slip
        return FilterState(goal + lag, speed + slip, -self.stiffness * lag - self.damping * slip)

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


@dataclass(frozen=True, eq=False)
class TimeOptimalFilter:
    """The fastest way to rest at a target inside limits of velocity and acceleration, > 0.

    Limits: (d,) or one number for all. The bang-bang law of the phase plane chatters when sampled;
    this is its sampled form. From the speed v towards the target, equal steps of at most a T bring
    the reference to rest in k periods T over a distance v T k / 2, if v <= k a T. The next
    speed is the largest from which it can still come to rest in this way before the target: with
    the distance B = X - w T / 2 that is left when the present speed w has run out,
    v = max over k of min(k a T, 2 B / ((k + 1) T)). A step later v (k - 1) / k is such a speed
    again, so that no step passes the target or brakes harder, and the last one, with k = 1, ends
    at rest on it. Where the reference is too fast for its target it brakes as hard as it may.
    """

    velocity: Any
    acceleration: Any

    def __post_init__(self) -> None:
        for name in ("velocity", "acceleration"):
            object.__setattr__(self, name, rate_limit(getattr(self, name), name))

    def step(self, state: FilterState, target: Any, period: float) -> FilterState:
        """The state one period, s, on, towards a target (d,). Raises InvalidInput."""
        x, goal, _, dt = _inputs(state, target, 0.0, period)
        top = limit_for(self.velocity, "velocity", x)
        push = limit_for(self.acceleration, "acceleration", x)
        side = np.where(goal >= x, 1.0, -1.0)
        distance, speed = np.abs(goal - x), side * state.velocity
        change = push * dt
        room = np.maximum(distance - 0.5 * speed * dt, 0.0)
        periods = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * room / (change * dt)) - 1.0))
        best = np.maximum(periods * change, 2.0 * room / ((periods + 2.0) * dt))
        # With limits just lowered the speed may be above the top: it falls as fast as it may.
        slowest = speed - change
        fastest = np.maximum(slowest, np.minimum(speed + change, top))
        chosen = np.clip(best, slowest, fastest)
        moved = x + side * 0.5 * (speed + chosen) * dt
        rests = (np.abs(goal - moved) <= _REACHED * (np.abs(goal) + np.abs(x))) & (
            np.abs(chosen) <= 1e-9 * change
        )
        velocity = np.where(rests, 0.0, side * chosen)
        return FilterState(np.where(rests, goal, moved), velocity, (velocity - state.velocity) / dt)


def _inputs(
    state: FilterState, target: Any, velocity: Any, period: float
) -> tuple[Float64Array, Float64Array, Float64Array, float]:
    if not isinstance(state, FilterState):
        raise InvalidInput(f"state: expected a FilterState, got {type(state).__name__}")
    x = state.position
    goal = check.array(target, "target", shape=(len(x),))
    shape = () if np.ndim(velocity) == 0 else (len(x),)
    speed = np.broadcast_to(check.array(velocity, "velocity", shape=shape), x.shape)
    return x, goal, speed, check_period(period)


def check_period(period: Any) -> float:
    """`period` as a number of seconds that filters can step by."""
    return check.number(period, "period", at_least=_SHORTEST_PERIOD, at_most=_LONGEST_PERIOD)


def rate_limit(value: Any, name: str) -> Float64Array:
    """A limit of a rate: (d,) numbers > 0, or one for all."""
    limit = check.frozen(value, name, shape=() if np.ndim(value) == 0 else ("d",))
    if (limit <= 0.0).any():
        raise InvalidInput(f"{name}: expected limits > 0, got {limit.min()}")
    return limit


def limit_for(limit: Float64Array, name: str, x: Float64Array) -> Float64Array:
    """A checked limit for every dimension of x (d,)."""
    if limit.ndim and limit.shape != x.shape:
        raise InvalidInput(f"{name}: expected limits of {len(x)} dimensions, got {len(limit)}")
    return np.broadcast_to(limit, x.shape)
