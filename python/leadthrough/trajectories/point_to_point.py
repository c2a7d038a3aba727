"""The fastest motion between two states inside limits of velocity, acceleration and jerk.

It is computed by ruckig, an optional dependency that the extra `ruckig` installs.

Source: Berscheid and Kroeger 2021, "Jerk-limited real-time trajectory generation with arbitrary
target states".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import optional
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories.filters import limit_for, rate_limit
from leadthrough.trajectories.minimum_jerk import State, checked_state
from leadthrough.trajectories.spline import Spline

# Phases shorter than this, s, are rounding.
_NO_PHASE = 1e-12
# Beyond these ruckig's quartics lose their digits.
_LARGEST = 1e6


def point_to_point(
    start: State | ArrayLike,
    end: State | ArrayLike,
    *,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    jerk: ArrayLike,
) -> Spline:
    """The fastest motion from one state to another; all dimensions arrive together.

    Args:
        start: a State, or a position (d,) to rest at.
        end: a State, or a position (d,) to rest at.
        velocity: limit > 0, (d,) or one number for all dimensions.
        acceleration: limit > 0, (d,) or one number for all dimensions.
        jerk: limit > 0, (d,) or one number for all dimensions.

    Raises:
        InvalidInput: if the states are the same or outside the limits, or the shapes do not fit.
        MissingDependency: if ruckig is not installed.
    """
    first = checked_state(start, "start", None)
    last = checked_state(end, "end", len(first[0]))
    if np.array_equal(first, last):
        raise InvalidInput("end: expected a state other than start")
    rates = [
        limit_for(rate_limit(limit, name), name, first[0])
        for limit, name in ((velocity, "velocity"), (acceleration, "acceleration"), (jerk, "jerk"))
    ]
    if np.abs([*first, *last, *rates]).max() > _LARGEST:
        raise InvalidInput(f"start, end, limits: expected numbers up to {_LARGEST:g}")
    return _solved(first, last, rates)


def _solved(
    first: tuple[Float64Array, ...], last: tuple[Float64Array, ...], rates: list[Float64Array]
) -> Spline:
    ruckig = optional.load("ruckig", extra="ruckig")
    # Given fewer numbers than dimensions, or none, ruckig reads beyond its arrays: all have d here.
    task = ruckig.InputParameter(len(first[0]))
    task.current_position, task.current_velocity, task.current_acceleration = map(list, first)
    task.target_position, task.target_velocity, task.target_acceleration = map(list, last)
    task.max_velocity, task.max_acceleration, task.max_jerk = map(list, rates)
    motion = ruckig.Trajectory(len(first[0]))
    try:
        result = ruckig.Ruckig(len(first[0])).calculate(task, motion)
    except ruckig.RuckigError as error:
        raise InvalidInput(
            f"start, end: expected states inside the limits: {str(error).strip()}"
        ) from None
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise InvalidInput(f"start, end: no motion inside the limits joins them ({result})")
    return _spline(motion)


def _spline(motion: Any) -> Spline:  # Any: ruckig ships no types
    """The cubic pieces between all times at which a dimension's jerk changes."""
    changes = [0.0, motion.duration]
    for profile in motion.profiles[0]:
        changes.extend(float(profile.brake.duration) + np.cumsum(profile.t))
        changes.extend(np.cumsum(profile.brake.t))
    times = np.unique(np.clip(changes, 0.0, motion.duration))
    times = times[np.concatenate([[True], np.diff(times) > _NO_PHASE])]
    states = np.array([motion.at_time(t)[:3] for t in times])
    steps = np.diff(times)[:, None]
    jerks = np.diff(states[:, 2], axis=0) / steps
    rows = [states[:-1, 0], states[:-1, 1], 0.5 * states[:-1, 2], jerks / 6.0]
    return Spline(times, np.stack(rows, axis=1))
