"""Obstacles and limits of a primitive's motion.

Steering around an obstacle's middle (Hoffmann et al. 2009, Pastor et al. 2009) with barriers under
it: the least accelerations that keep every distance from falling below 0 (Ames et al. 2019,
"Control barrier functions"); a motion that presses on an obstacle is led around it. The kernels
hold these laws.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, NoPath, UnsupportedQuery
from leadthrough.models.dmp.transformation import TransformationSystem, end_of
from leadthrough.models.queries import checked_limits
from leadthrough.shapes import Shape, check_shapes, compiled
from leadthrough.trajectories.minimum_jerk import minimum_jerk_time_scaling

# Fractions of the demonstration's size: the distance to keep from obstacles, and the one at which
# steering fades. Nearer ends halve the first.
_MARGIN = 0.02
_MIN_MARGIN = 1e-4
_REACH = 0.25
# The last part of a motion, over which the error that a detour has left is blended out.
_LATEST_PUSH = 0.9

StateT = TypeVar("StateT", core.PointState, core.PoseState)


@dataclass(frozen=True, eq=False)
class Constraints:
    """Obstacles and limits that a motion respects."""

    obstacles: tuple[Shape, ...]  # shapes to keep clear of
    lower: Float64Array  # lower limits (channels,); empty without limits
    upper: Float64Array  # upper limits (channels,); empty without limits

    @property
    def are_none(self) -> bool:
        """Whether there are no obstacles and no limits."""
        return not self.obstacles and len(self.lower) == 0


def check_constraints(
    obstacles: Iterable[Shape],
    limits: tuple[ArrayLike, ArrayLike] | None,
    *,
    dimensions: int | None,
    channels: int | None,
) -> Constraints:
    shapes = check_shapes(obstacles)
    if shapes and dimensions not in (2, 3):
        raise UnsupportedQuery(
            "obstacles: expected none; only points in two or three dimensions keep clear of them"
        )
    if limits is None:
        return Constraints(shapes, np.zeros(0), np.zeros(0))
    if channels is None:
        raise UnsupportedQuery("limits: expected none for poses; give walls as obstacles")
    return Constraints(shapes, *checked_limits(limits, (channels,)))


def roll(
    system: TransformationSystem,
    state: StateT,
    phases: Float64Array,
    *,
    constraints: Constraints,
    size: float,
) -> tuple[Float64Array, Float64Array]:
    """Values and slopes (n, channels) at phases (n,) from a state on."""
    forces, start = system.forces, (state.value, state.slope)
    if constraints.are_none:
        return core.dmp_rollout(forces, state.course, *start, phases)
    goal = end_of(state.course)
    _check_ends(constraints, state.value, goal)
    near = np.stack([state.value, goal])
    scene = _avoidance_scene(constraints, near=near, size=size)
    values, slopes, last_push = core.dmp_rollout_around(forces, state.course, scene, *start, phases)
    if len(constraints.lower):  # a barrier's steps leave rounding beyond it
        values = np.clip(values, constraints.lower, constraints.upper)
    if system.form == "blended" and last_push > 0.0:
        values, slopes = _settled(values, slopes, phases, goal, last_push)
    _check_clear(constraints.obstacles, values)
    return values, slopes


def step_within(
    system: TransformationSystem,
    state: StateT,
    dt: float,
    acceleration: Float64Array,
    *,
    constraints: Constraints,
    size: float,
) -> StateT:
    """The state dt s later, under an acceleration and constraints."""
    near = end_of(state.course)[None]
    scene = _avoidance_scene(constraints, near=near, size=size)
    return state.led_around(system.forces, dt, acceleration, scene)


def _check_ends(constraints: Constraints, start: Float64Array, goal: Float64Array) -> None:
    """Refuses ends (d,) that the constraints do not allow."""
    lower, upper = constraints.lower, constraints.upper
    for name, point in (("start", start), ("goal", goal)):
        if len(lower) and not ((lower <= point) & (point <= upper)).all():
            raise check.refused(name, f"a point inside the limits {lower} to {upper}", point)
        if (_clearances(constraints.obstacles, point[None]) <= 0.0).any():
            position = point[:3].round(4).tolist()
            raise NoPath(f"{name}: {position} lies in an obstacle", reason=f"{name}_in_wall")


def _avoidance_scene(
    constraints: Constraints, *, near: Float64Array, size: float
) -> core.AvoidanceScene:
    """Constraints as the kernels take them."""
    obstacles, size = constraints.obstacles, size or 1.0
    allowed = 0.5 * _clearances(obstacles, near).min(axis=1)
    return core.AvoidanceScene(
        compiled(obstacles),
        np.clip(allowed, _MIN_MARGIN * size, _MARGIN * size),
        _REACH * size,
        constraints.lower,
        constraints.upper,
    )


def _clearances(obstacles: Sequence[Shape], points: Float64Array) -> Float64Array:
    """Signed distances (obstacles, n) of points (n, d); in two dimensions they lie at z = 0."""
    in_space = np.zeros((len(points), 3))
    in_space[:, : points.shape[1]] = points[:, :3]
    return np.array([shape.distance(in_space) for shape in obstacles]).reshape(-1, len(points))


def _settled(
    values: Float64Array,
    slopes: Float64Array,
    phases: Float64Array,
    goal: Float64Array,
    last_push: float,
) -> tuple[Float64Array, Float64Array]:
    """The motion (n, channels), its final error blended out since the phase of the last push."""
    since = min(last_push, _LATEST_PUSH)
    s = np.clip((phases - since) / (1.0 - since), 0.0, 1.0)
    blend = minimum_jerk_time_scaling(s)
    speed = 30.0 * s**2 * (1.0 - s) ** 2 / (1.0 - since)
    off = goal - values[-1]
    return values + np.outer(blend, off), slopes + np.outer(speed, off)


def _check_clear(obstacles: Sequence[Shape], points: Float64Array) -> None:
    """Refuses a motion that hits an obstacle."""
    gaps = _clearances(obstacles, points)
    if (gaps < 0.0).any():
        index = int(np.argmax((gaps < 0.0).any(axis=0)))
        raise NoPath(
            f"obstacles: steering around them fails at sample {index}, {points[index]}; "
            "plan with FastMarching, or pass via points",
            reason="not_cleared",
        )
