"""The fastest way to rest at a target inside limits of velocity, acceleration and jerk, stepped.

In every period the reference ramps towards its highest velocity for as long as a stop begun
afterwards would end before the target; then it stops. It needs only the present state, so targets
may change at any time. Each motion is the time-optimal one, its samples lie on it exactly, whatever
the period, and the last of them is the target: only a reference that cannot stop in time
overshoots, and nothing chatters.

A state outside the limits returns inside: an acceleration at the jerk's limit, a velocity by the
fastest ramp to its own limit. So does a velocity that its acceleration must carry over a limit.

Source: the problem is that of Lo Bianco and Ghilardelli 2014, whose law switches on a sliding
surface; this one is Castain and Paul's, 1984, "An on-line dynamic trajectory generator".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr
from leadthrough.trajectories.filters import FilterState, check_period, rate_limit

_RATES = ("velocity", "acceleration", "jerk")
# Beyond this, sums of cubes lose all digits.
_LARGEST = 1e12


@dataclass(frozen=True, eq=False, init=False)
class JerkFilter(ShortRepr):
    """The fastest way to rest at a target inside limits of velocity, acceleration and jerk.

    Each limit is > 0, (d,) or one number for all dimensions.

    Attributes:
        velocity: limit in the positive direction.
        acceleration: limit in the positive direction.
        jerk: limit in the positive direction.
        velocity_down: limit in the negative direction, by default the same.
        acceleration_down: limit in the negative direction, by default the same.
        jerk_down: limit in the negative direction, by default the same.

    Raises:
        InvalidInput: if a limit is not > 0 or above 1e12, or not all are of one dimension.
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
            _RATES,
            (velocity, acceleration, jerk),
            (velocity_down, acceleration_down, jerk_down),
            strict=True,
        ):
            limits[f"{name}_down"] = rate_limit(up if down is None else down, f"{name}_down")
            limits[name] = rate_limit(up, name)
        vars(self).update(limits, _limits=_table(limits))

    def step(self, state: FilterState, target: ArrayLike, period: float) -> FilterState:
        """The state one period later, each dimension on its own fastest way to the target.

        Args:
            state: the present one.
            target: (d,).
            period: s, 1e-7 to 1e5.

        Raises:
            InvalidInput: if the shapes do not fit or a number is out of its range.
        """
        states, limits, goal = self._checked(state, target)
        return _state(_core.step_each(states, limits, goal, check_period(period)))

    def step_together(self, state: FilterState, target: ArrayLike, period: float) -> FilterState:
        """The state one period later; all dimensions come to rest when the slowest of them can.

        The others keep a lower speed on their way. Only one whose hardest stop happens to end on
        its target cannot wait, and arrives earlier.

        Args:
            state: as for `step`.
            target: as for `step`.
            period: as for `step`.

        Raises:
            InvalidInput: as for `step`.
        """
        states, limits, goal = self._checked(state, target)
        return _state(_core.step_together(states, limits, goal, check_period(period)))

    def durations(self, state: FilterState, target: ArrayLike) -> Float64Array:
        """Times (d,), s, that `step` takes to rest at the target.

        Args:
            state: the present one.
            target: (d,).

        Raises:
            InvalidInput: if the shapes do not fit or a number is out of its range.
        """
        return np.asarray(_core.times_to_rest(*self._checked(state, target)))

    def resting_place(self, state: FilterState) -> Float64Array:
        """Positions (d,) at which the dimensions rest if they stop as fast as they may.

        Args:
            state: the present one.

        Raises:
            InvalidInput: if its shape does not fit the limits or a number is out of its range.
        """
        states, limits, _ = self._checked(state, getattr(state, "position", ()))
        return np.asarray(_core.resting_places(states, limits))

    def along(self, direction: ArrayLike) -> JerkFilter:
        """The filter of a position on a line, such that all dimensions keep their limits.

        Args:
            direction: of the line, (d,); a dimension that does not move does not bind.

        Raises:
            InvalidInput: if it does not fit the limits.
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

    def _checked(
        self, state: FilterState, target: ArrayLike
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """States (3, d), limits (6, d), low and high, and targets (d,)."""
        if not isinstance(state, FilterState):
            raise InvalidInput(f"state: expected a FilterState, got {type(state).__name__}")
        states = np.array((state.position, state.velocity, state.acceleration))
        goal = check.array(target, "target", shape=state.position.shape)
        if max(np.abs(x).max(initial=0.0) for x in (states, goal)) > _LARGEST:
            raise InvalidInput(f"state, target: expected numbers up to {_LARGEST:g}")
        return states, self._limits_of(len(goal)), goal

    def _limits_of(self, dimensions: int) -> Float64Array:
        """Limits (6, d)."""
        size = self._limits.shape[1]
        if size == dimensions:  # the quick way, for control loops
            return self._limits
        if size not in {1, dimensions}:
            raise InvalidInput(f"limits: expected limits of {dimensions} dimensions, got {size}")
        return np.ascontiguousarray(np.broadcast_to(self._limits, (6, dimensions)))


def _table(limits: Mapping[str, Float64Array]) -> Float64Array:
    """Low and high bounds (6, d) of each rate; d is 1 where all limits are single numbers."""
    rows = [
        np.atleast_1d(-limit if name.endswith("_down") else limit) for name, limit in limits.items()
    ]
    sizes = {len(row) for row in rows if len(row) != 1}
    if len(sizes) > 1:
        raise InvalidInput(f"limits: expected as many of each, got {sorted(sizes)}")
    table = np.stack(np.broadcast_arrays(*rows))
    if np.abs(table).max(initial=0.0) > _LARGEST:
        raise InvalidInput(f"limits: expected numbers up to {_LARGEST:g}")
    return table


def _state(rows: Float64Array) -> FilterState:
    return FilterState(rows[0], rows[1], rows[2])
