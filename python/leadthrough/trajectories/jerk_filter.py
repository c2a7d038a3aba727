"""The fastest way to rest at a target inside limits of velocity, acceleration and jerk, stepped.

In every period the reference ramps towards its highest velocity for as long as a stop that begins
then ends before the target, and stops from there: it needs no more than the present state, so that
targets may change at any time. Each motion is the time-optimal one, its samples lie on it exactly,
whatever the period, and the last of them is the target: nothing overshoots but what cannot stop in
time, and nothing chatters.

A state outside of the limits comes back: an acceleration at the jerk's limit, a velocity by the
fastest ramp to its own. So does a velocity that its acceleration is bound to carry over a limit.
Source: the problem is that of Lo Bianco and Ghilardelli 2014, whose law switches on a sliding
surface; this one is Castain and Paul's, 1984, "An on-line dynamic trajectory generator".
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories.filters import FilterState, check_period, rate_limit

_RATES = ("velocity", "acceleration", "jerk")
# Beyond it sums of cubes lose all digits.
_LARGEST = 1e12


@dataclass(frozen=True, eq=False)
class JerkFilter:
    """To rest at a target inside three limits, > 0: (d,) or one number for all.

    velocity_down, acceleration_down, jerk_down: limits, > 0, in the other direction, where they
    differ. Raises InvalidInput.
    """

    velocity: Any
    acceleration: Any
    jerk: Any
    velocity_down: Any = None
    acceleration_down: Any = None
    jerk_down: Any = None
    _limits: Float64Array = field(init=False, repr=False)  # (6, d or 1) low and high of each rate

    def __post_init__(self) -> None:
        sides = []
        for name in _RATES:
            up, down = getattr(self, name), getattr(self, f"{name}_down")
            sides.append((f"{name}_down", -1.0, up if down is None else down))
            sides.append((name, 1.0, up))
        rows = []
        for name, sign, value in sides:
            limit = rate_limit(value, name)
            object.__setattr__(self, name, limit)
            rows.append(sign * np.atleast_1d(limit))
        sizes = {len(row) for row in rows if len(row) != 1}
        if len(sizes) > 1:
            raise InvalidInput(f"limits: expected as many of each, got {sorted(sizes)}")
        table = np.stack(np.broadcast_arrays(*rows))
        if np.abs(table).max(initial=0.0) > _LARGEST:
            raise InvalidInput(f"limits: expected numbers up to {_LARGEST:g}")
        object.__setattr__(self, "_limits", table)

    def step(self, state: FilterState, target: Any, period: float) -> FilterState:
        """The state one period, s, on, each dimension on its way to the target (d,).

        Raises InvalidInput.
        """
        states, limits, goal = self._checked(state, target)
        return _state(_core.step_each(states, limits, goal, check_period(period)))

    def step_together(self, state: FilterState, target: Any, period: float) -> FilterState:
        """The same, but all dimensions come to rest at once: when the slowest of them can.

        The others keep so low a speed on their way. Only one whose hardest stop happens to end on
        its target cannot wait, and is there before.
        Raises InvalidInput.
        """
        states, limits, goal = self._checked(state, target)
        return _state(_core.step_together(states, limits, goal, check_period(period)))

    def durations(self, state: FilterState, target: Any) -> Float64Array:
        """The times (d,) s that `step` takes to rest at the target (d,). Raises InvalidInput."""
        return np.asarray(_core.times_to_rest(*self._checked(state, target)))

    def resting_place(self, state: FilterState) -> Float64Array:
        """Where (d,) each dimension rests if it stops at once. Raises InvalidInput."""
        states, limits, _ = self._checked(state, getattr(state, "position", ()))
        return np.asarray(_core.resting_places(states, limits))

    def along(self, direction: Any) -> JerkFilter:
        """The filter of a place on a line of direction (d,): all dimensions keep their limits.

        One that does not move does not bind. Raises InvalidInput.
        """
        u = check.array(direction, "direction", shape=("d",))
        if not u.any():  # any limit does, where nothing moves
            return JerkFilter(1.0, 1.0, 1.0)
        limits = self._limits_of(len(u)).reshape(3, 2, len(u))  # rate, low and high, dimension
        with np.errstate(divide="ignore"):
            shares = np.abs(limits / u)
        shares[:, :, u == 0.0] = np.inf
        forwards = np.where(u > 0.0, shares[:, 1], shares[:, 0]).min(axis=1)
        backwards = np.where(u > 0.0, shares[:, 0], shares[:, 1]).min(axis=1)
        return JerkFilter(*forwards, *backwards)

    def _checked(
        self, state: FilterState, target: Any
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """States (3, d), limits (6, d), low and high, and targets (d,)."""
        if not isinstance(state, FilterState):
            raise InvalidInput(f"state: expected a FilterState, got {type(state).__name__}")
        states = np.stack([state.position, state.velocity, state.acceleration])
        goal = check.array(target, "target", shape=state.position.shape)
        if max(np.abs(x).max(initial=0.0) for x in (states, goal)) > _LARGEST:
            raise InvalidInput(f"state, target: expected numbers up to {_LARGEST:g}")
        return states, self._limits_of(len(goal)), goal

    def _limits_of(self, dimensions: int) -> Float64Array:
        """Limits (6, d)."""
        size = self._limits.shape[1]
        if size not in {1, dimensions}:
            raise InvalidInput(f"limits: expected some of {dimensions} dimensions, got {size}")
        return np.ascontiguousarray(np.broadcast_to(self._limits, (6, dimensions)))


def _state(rows: Float64Array) -> FilterState:
    return FilterState(rows[0], rows[1], rows[2])
