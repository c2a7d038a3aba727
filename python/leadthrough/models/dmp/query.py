"""Parts of the queries that movement primitives answer: ends, via points, obstacles and limits.

Steering around an obstacle's middle (Hoffmann et al. 2009, Pastor et al. 2009) with barriers under
it: the least accelerations that keep every distance from falling below 0 (Ames et al. 2019,
"Control barrier functions"); a motion that presses on an obstacle is led around it. The kernels
hold these laws.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import MAX_NUMBER, Float64Array, InvalidInput, NoPath, UnsupportedQuery
from leadthrough.models.dmp import transformation
from leadthrough.models.dmp.transformation import Ends, TransformationSystem, end_of
from leadthrough.models.queries import CheckedQuery, Via, checked_limits
from leadthrough.motion import Target
from leadthrough.shapes import Shape, check_shapes, compiled
from leadthrough.trajectories.minimum_jerk import minimum_jerk_time_scaling

# Steps this many durations long come from a wrong unit of dt.
_MAX_STEP = 1000.0


def check_step(dt: float, lag: float, duration: float) -> float:
    """The time by which the motion goes on in a step of dt s."""
    span = check.number(dt, "dt", above=0.0, at_most=_MAX_STEP * duration)
    return span / (1.0 + check.number(lag, "lag", at_least=0.0))


def check_state(state: object) -> None:
    """Refuses what `begin` and `step` of a movement primitive did not make."""
    if not hasattr(state, "tick"):
        raise check.refused("state", "one from begin or step", type(state).__name__)


def check_final_velocity(velocity: ArrayLike | None, form: str) -> None:
    """Refuses a final velocity with a form that ends at rest."""
    if velocity is not None and form != "blended":
        raise UnsupportedQuery(
            f"final_velocity: the form {form!r} ends at rest; leave it out, or fit with the form "
            '"blended"'
        )


def check_channels(value: Any, name: str, count: int) -> Float64Array:
    """`value` as an array (count,) whose products stay finite."""
    given = check.array(value, name, shape=(count,))
    if np.abs(given).max() > MAX_NUMBER:
        raise InvalidInput(f"{name}: expected numbers up to {MAX_NUMBER:.0e}, got {given}")
    return given


def as_pose(value: Target | None, name: str) -> tuple[Any, Float64Array | None]:
    """Position, not checked yet, and orientation (4,) of a query; None where left out."""
    if isinstance(value, tuple | list) and len(value) == 2:
        return value[0], check.quaternions(value[1], name, shape=(4,))
    return value, None


def pose_acceleration(coupling: ArrayLike) -> Float64Array:
    """A coupling (3,) or (6,) as linear and angular acceleration (6,)."""
    given = check.array(coupling, "coupling", shape=("n",))
    if len(given) not in (3, 6):
        raise InvalidInput(f"coupling: expected shape (3,) or (6,), got {given.shape}")
    return np.append(check_channels(given, "coupling", len(given)), np.zeros(6 - len(given)))


def ends_of(query: CheckedQuery, learned: Ends, duration: float) -> Ends:
    """Ends that a query asks for, with the velocities of a motion of a duration, s."""

    def slope(value: ArrayLike | None, name: str, nominal: Float64Array) -> Float64Array:
        if value is None:
            return nominal
        return check_channels(value, name, len(nominal)) * min(duration, MAX_NUMBER)

    return Ends(
        _or(query.start, "start", learned.start),
        _or(query.goal, "goal", learned.goal),
        slope(query.start_velocity, "start_velocity", learned.start_slope),
        slope(query.final_velocity, "final_velocity", learned.goal_slope),
    )


def moved_ends(learned: Ends, start: Target | None, goal: Target | None) -> Ends:
    return learned.moved(_or(start, "start", learned.start), _or(goal, "goal", learned.goal))


def _or(value: Target | None, name: str, nominal: Float64Array) -> Float64Array:
    return nominal if value is None else check_channels(value, name, len(nominal))


def course_through(
    learned: TransformationSystem, direct: core.DmpCourse, ends: Ends, via: Via, *, count: int
) -> core.DmpCourse:
    if len(via) == 0:
        return direct
    phases, points = _via(via, count)
    asked = np.concatenate([[0.0], phases])
    values, _ = core.dmp_rollout(learned.forces, direct, ends.start, ends.start_slope, asked)
    offsets = np.zeros_like(values[1:])
    offsets[:, :count] = points - values[1:, :count]
    return transformation.with_via(direct, list(zip(phases, offsets, strict=True)))


def _via(via: Via, count: int) -> tuple[Float64Array, Float64Array]:
    pairs = list(via)
    if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in pairs):
        raise InvalidInput(f"via: expected pairs (phase, point), got {via!r}")
    phases = check.array([pair[0] for pair in pairs], "via", shape=("n",))
    points = [check_channels(pair[1], "via", count) for pair in pairs]
    if phases[0] <= 0.0 or phases[-1] >= 1.0 or (np.diff(phases) <= 0.0).any():
        raise InvalidInput(f"via: expected phases that rise between 0 and 1, got {phases}")
    return phases, np.array(points)


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
