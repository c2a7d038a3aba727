"""Parts of the queries that movement primitives answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.demonstrated import LARGEST
from leadthrough.models.dmp import springs
from leadthrough.models.dmp.springs import Ends, Springs

# Steps this many durations long are a slip of the unit of dt.
_LONGEST_STEP = 1000.0


def check_duration(duration: float | None, usual: float, name: str = "duration") -> float:
    """The duration asked for, s, or the usual one. Raises InvalidInput."""
    return usual if duration is None else check.number(duration, name, above=0.0)


def check_step(dt: float, lag: float, duration: float) -> float:
    """The time that the motion goes on by in a step of dt s. Raises InvalidInput."""
    span = check.number(dt, "dt", above=0.0, at_most=_LONGEST_STEP * duration)
    return span / (1.0 + check.number(lag, "lag", at_least=0.0))


def check_channels(value: Any, name: str, count: int) -> Float64Array:
    """`value` as an array (count,) whose products stay finite. Raises InvalidInput."""
    given = check.array(value, name, shape=(count,))
    if np.abs(given).max() > LARGEST:
        raise InvalidInput(f"{name}: expected numbers up to {LARGEST:.0e}, got {given}")
    return given


def ends_of(
    learned: Ends,
    *,
    start: Any,
    goal: Any,
    start_velocity: Any,
    final_velocity: Any,
    duration: float,
) -> Ends:
    """The ends asked for; what is None is as learned. Velocities are a second.

    Raises InvalidInput.
    """

    def channels(value: Any, name: str, usual: Float64Array, scale: float = 1.0) -> Float64Array:
        if value is None:
            return usual
        return check_channels(value, name, len(usual)) * min(scale, LARGEST)

    return Ends(
        channels(start, "start", learned.start),
        channels(goal, "goal", learned.goal),
        channels(start_velocity, "start_velocity", learned.start_slope, duration),
        channels(final_velocity, "final_velocity", learned.goal_slope, duration),
    )


def course_through(
    learned: Springs, ends: Ends, via: Sequence[tuple[float, Any]], *, count: int
) -> _core.DmpCourse:
    """The course from end to end; its first `count` channels pass the via points (count,).

    Raises InvalidInput.
    """
    direct = springs.course(learned.form, ends)
    if not isinstance(via, Sequence):
        raise InvalidInput(f"via: expected a sequence, got {type(via).__name__}")
    if len(via) == 0:
        return direct
    phases, points = _via(via, count)
    asked = np.concatenate([[0.0], phases])
    values, _ = _core.dmp_rollout(learned.forces, direct, ends.start, ends.start_slope, asked)
    offsets = np.zeros_like(values[1:])
    offsets[:, :count] = points - values[1:, :count]
    return springs.course(learned.form, ends, list(zip(phases, offsets, strict=True)))


def _via(via: Sequence[tuple[float, Any]], count: int) -> tuple[Float64Array, Float64Array]:
    pairs = list(via)
    if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in pairs):
        raise InvalidInput(f"via: expected pairs of phase and point, got {via!r}")
    phases = check.array([pair[0] for pair in pairs], "via", shape=("n",))
    points = [check_channels(pair[1], "via", count) for pair in pairs]
    if phases[0] <= 0.0 or phases[-1] >= 1.0 or (np.diff(phases) <= 0.0).any():
        raise InvalidInput(f"via: expected phases that rise between 0 and 1, got {phases}")
    return phases, np.array(points)
