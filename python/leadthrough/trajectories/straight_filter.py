"""A filter that leads a reference straight to its target, all dimensions at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr
from leadthrough.trajectories.filters import FilterState
from leadthrough.trajectories.jerk_filter import JerkFilter

# A target this far off a line, relative to its distance, lies on it: rounding.
_ON_THE_LINE = 1e-12


@dataclass(frozen=True, eq=False)
class LineState(FilterState):
    """A state on a line, besides its position, velocity and acceleration.

    Attributes:
        origin: where the line begins, (d,).
        direction: unit vector (d,), or 0 where there is no line yet.
        along: the state along the line, of one dimension.
        limits: of all dimensions.
        scalar: limits along the line.
    """

    origin: Float64Array
    direction: Float64Array
    along: FilterState
    limits: JerkFilter
    scalar: JerkFilter


@dataclass(frozen=True, eq=False)
class StraightFilter(ShortRepr):
    """The fastest way to rest at a target along a straight line, inside all dimensions' limits.

    A target that changes during the motion is approached on the same line if it lies on it;
    otherwise the reference stops as fast as it may and leaves for the target from there.

    Attributes:
        limits: of every dimension.

    Raises:
        InvalidInput: if they are not a JerkFilter.
    """

    limits: JerkFilter

    def __post_init__(self) -> None:
        if not isinstance(self.limits, JerkFilter):
            what = type(self.limits).__name__
            raise InvalidInput(f"limits: expected a JerkFilter, got {what}")

    def step(self, state: FilterState, target: ArrayLike, period: float) -> LineState:
        """The state one period later.

        Args:
            state: at rest, or one that this method returned.
            target: (d,).
            period: s, 1e-7 to 1e5.

        Raises:
            InvalidInput: if the state moves and is not on a line, the shapes do not fit or a number
                is out of its range.
        """
        line = self._on_a_line(state)
        goal = check.array(target, "target", shape=line.position.shape)
        place = _place(line, goal)
        if place is None and not _moves(line.along):
            line = self._towards(line.position, goal)
            place = _place(line, goal)
        stop = line.scalar.resting_place(line.along) if place is None else np.array([place])
        along = line.scalar.step(line.along, stop, period)
        there = place is not None and along.position[0] == place and not _moves(along)
        moved = goal if there else line.origin + along.position * line.direction
        velocity, acceleration = (
            rate * line.direction for rate in (along.velocity, along.acceleration)
        )
        return replace(
            line, position=moved, velocity=velocity, acceleration=acceleration, along=along
        )

    def _on_a_line(self, state: FilterState) -> LineState:
        if isinstance(state, LineState):
            if state.limits is self.limits:
                return state
            return replace(state, limits=self.limits, scalar=self.limits.along(state.direction))
        if not isinstance(state, FilterState):
            raise InvalidInput(f"state: expected a FilterState, got {type(state).__name__}")
        if _moves(state):
            raise InvalidInput("state: expected one at rest or one that this filter returned")
        return self._towards(state.position, state.position)

    def _towards(self, origin: Float64Array, goal: Float64Array) -> LineState:
        """At rest at the origin of the line to a goal; at the goal the direction is 0."""
        way, still = goal - origin, np.zeros_like(origin)
        length = float(np.linalg.norm(way))
        direction = way / length if length > 0.0 else still
        rest, scalar = FilterState.at_rest([0.0]), self.limits.along(direction)
        return LineState(origin, still, still, origin, direction, rest, self.limits, scalar)


def _place(line: LineState, goal: Float64Array) -> float | None:
    """Distance of a goal along the line, or None where it does not lie on it."""
    way = goal - line.origin
    place = float(way @ line.direction)
    off = np.abs(way - place * line.direction).max(initial=0.0)
    return place if off <= _ON_THE_LINE * (abs(place) + np.abs(goal).max(initial=0.0)) else None


def _moves(state: FilterState) -> bool:
    return bool(state.velocity.any() or state.acceleration.any())
