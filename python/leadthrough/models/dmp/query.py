"""Parts of the queries that movement primitives answer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import MAX_NUMBER, Float64Array, InvalidInput, UnsupportedQuery
from leadthrough.models.dmp import transformation
from leadthrough.models.dmp.transformation import Ends, TransformationSystem
from leadthrough.models.queries import CheckedQuery, Via
from leadthrough.motion import Target

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
