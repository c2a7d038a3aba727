"""A filter that keeps to straight lines; of a moving target, in the frame that moves with it.

Source: as for `filters`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.trajectories.filters import FilterState, JerkFilter, check_period

# A target or a velocity this far off a line, relative to its size, lies on it: rounding.
_ON_THE_LINE = 1e-12


@dataclass(frozen=True, eq=False)
class LineState(FilterState):
    """A state on a line, besides its position, velocity and acceleration.

    Attributes:
        origin: of the line, (d,).
        direction: unit vector (d,), or 0 where there is no line yet.
        drift: velocity of the line, (d,), which is that of the target.
        along: the state along the line, of one dimension.
        limits: of all dimensions.
        scalar: limits along the line.
    """

    origin: Float64Array
    direction: Float64Array
    drift: Float64Array
    along: FilterState
    limits: JerkFilter
    scalar: JerkFilter

    def __post_init__(self) -> None:
        super().__post_init__()
        shape = self.position.shape
        for name in ("origin", "direction", "drift"):
            vars(self)[name] = check.frozen(getattr(self, name), name, shape=shape)
        check.instance(self.along, "along", FilterState)
        for name in ("limits", "scalar"):
            check.instance(getattr(self, name), name, JerkFilter)

    def with_parts(self, **parts: Any) -> LineState:  # Any: its fields
        """The state with other parts that are just computed."""
        return check.computed(LineState, **(vars(self) | parts))

    @property
    def loose(self) -> bool:
        """Whether it moves, seen from its line, but not along it."""
        return not self.direction.any() and bool(
            (self.velocity - self.drift).any() or self.acceleration.any()
        )


@dataclass(frozen=True, eq=False)
class StraightFilter(ShortRepr):
    """Time-optimal motion to a target along a straight line, within all dimensions' limits.

    A target that changes during the motion is approached on the same line if it lies on it;
    otherwise the reference stops as fast as it may and leaves for the target from there. Of a
    target that moves, all this holds in the frame that moves with it: the reference takes on its
    velocity, comes straight to it and follows it. From a state that moves along no line, as after a
    change of the target's velocity, all dimensions go to the target together.

    Attributes:
        limits: of every dimension. A filter with other limits goes on from any state.
    """

    limits: JerkFilter

    def __post_init__(self) -> None:
        check.instance(self.limits, "limits", JerkFilter)

    def step(
        self,
        state: FilterState,
        target: ArrayLike,
        period: float,
        *,
        velocity: ArrayLike = 0.0,
    ) -> LineState:
        """The state one period later.

        Args:
            target: (d,), one period later.
            velocity: the target's, (d,) or one number.
        """
        check.instance(state, "state", FilterState)
        goal = check.array(target, "target", shape=state.position.shape)
        drift = self.limits.followed(velocity, len(goal))
        line = self._on_a_line(state, drift)
        if line.loose:
            moved = self.limits.step_together(state, goal, period, velocity=drift)
            return line.with_parts(**vars(moved))
        return self._along(line, goal, check_period(period))

    def _along(self, line: LineState, goal: Float64Array, dt: float) -> LineState:
        """The state one period later, in the frame that is the world at its beginning."""
        shift = line.drift * dt
        place = _place(line, goal - shift)
        if place is None and not _moves(line.along):
            line = self._towards(line.position, goal - shift, line.drift)
            place = _place(line, goal - shift)
        stop = line.scalar.resting_place(line.along) if place is None else np.array([place])
        along = line.scalar.step(line.along, stop, dt)
        there = place is not None and along.position[0] == place and not _moves(along)
        origin = line.origin + shift
        moved = goal.copy() if there else origin + along.position * line.direction
        velocity, acceleration = (
            rate * line.direction for rate in (along.velocity, along.acceleration)
        )
        return line.with_parts(
            position=moved,
            velocity=velocity + line.drift,
            acceleration=acceleration,
            origin=origin,
            along=along,
        )

    def _on_a_line(self, state: FilterState, drift: Float64Array) -> LineState:
        """The state with the line that it moves along, seen from a frame; loose without any."""
        if isinstance(state, LineState) and (state.drift == drift).all():
            if state.limits is self.limits:
                return state
            scalar = self._scalar(state.direction, drift)
            return state.with_parts(limits=self.limits, scalar=scalar)
        still, rate = np.zeros_like(drift), state.velocity - drift
        fastest = max(rate, state.acceleration, key=np.linalg.norm)
        size = float(np.linalg.norm(fastest))
        direction = fastest / size if size > 0.0 else still
        speed, push = float(rate @ direction), float(state.acceleration @ direction)
        off = np.hypot(rate - speed * direction, state.acceleration - push * direction)
        if off.max(initial=0.0) > _ON_THE_LINE * size:
            direction, speed, push = still, 0.0, 0.0
        along = FilterState(np.zeros(1), np.array([speed]), np.array([push]))
        return LineState(
            state.position,
            state.velocity,
            state.acceleration,
            state.position,
            direction,
            drift,
            along,
            self.limits,
            self._scalar(direction, drift),
        )

    def _towards(self, origin: Float64Array, goal: Float64Array, drift: Float64Array) -> LineState:
        """At rest at the origin of the line to a goal, seen from a frame; 0 long at the goal."""
        way, still = goal - origin, np.zeros_like(origin)
        length = float(np.linalg.norm(way))
        direction = way / length if length > 0.0 else still
        rest, scalar = FilterState.at_rest([0.0]), self._scalar(direction, drift)
        return LineState(origin, drift, still, origin, direction, drift, rest, self.limits, scalar)

    def _scalar(self, direction: Float64Array, drift: Float64Array) -> JerkFilter:
        return self.limits.relative_to(drift).along(direction)


def _place(line: LineState, goal: Float64Array) -> float | None:
    """Distance of a goal along the line, or None where it does not lie on it."""
    way = goal - line.origin
    place = float(way @ line.direction)
    off = np.abs(way - place * line.direction).max(initial=0.0)
    return place if off <= _ON_THE_LINE * (abs(place) + np.abs(goal).max(initial=0.0)) else None


def _moves(state: FilterState) -> bool:
    return bool(state.velocity.any() or state.acceleration.any())
