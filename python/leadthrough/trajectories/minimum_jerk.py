"""Curves with the least integral of the squared jerk, and the fastest ones of bounded jerk.

The fastest motion between two states is computed by ruckig, which the extra `ruckig` installs.

Source: Flash and Hogan 1985; Berscheid and Kroeger 2021, "Jerk-limited real-time trajectory
generation with arbitrary target states".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.trajectories import curve
from leadthrough.trajectories.bezier import Bezier
from leadthrough.trajectories.curve import Spline
from leadthrough.trajectories.filters import limit_for, rate_limit
from leadthrough.trajectories.interpolation import passing

# Coefficients of u^3, u^4 and u^5 (rows) of a quintic over u from 0 to 1 without acceleration at
# its ends, for its rise from 0, its slope at 0 and its slope at 1 (columns).
QUINTIC = np.array([[10.0, -6.0, -4.0], [-15.0, 8.0, 7.0], [6.0, -3.0, -3.0]])

_ROUNDING = 1e-9  # by which a fraction may leave [0, 1]


@dataclass(frozen=True, eq=False, init=False)
class State(ShortRepr):
    """Position, velocity and acceleration of a motion; it rests by default.

    Attributes:
        position: (d,).
        velocity: (d,); one number holds for all dimensions.
        acceleration: (d,); one number holds for all dimensions.
    """

    position: Float64Array
    velocity: Float64Array
    acceleration: Float64Array

    def __init__(
        self, position: ArrayLike, velocity: ArrayLike = 0.0, acceleration: ArrayLike = 0.0
    ) -> None:
        x = check.frozen(position, "position", shape=("d",))
        rates = {"velocity": velocity, "acceleration": acceleration}
        vars(self).update(
            position=x,
            **{name: check.row(rate, name, width=len(x)) for name, rate in rates.items()},
        )


def minimum_jerk_time_scaling(u: ArrayLike, height: ArrayLike = 1.0) -> Float64Array:
    """The minimum-jerk rise from 0 at u = 0 to a height at u = 1, at rest at both ends.

    Args:
        u: fractions (n,) of the duration, or of the way, from 0 to 1.
        height: final value, one number or (n,).

    Returns:
        Values (n,).

    Source: Flash and Hogan 1985.
    """
    cubic, quartic, quintic = QUINTIC[:, 0].tolist()
    x = check.array_of_rank(u, "u", shapes=((), ("n",)))
    if x.size and not (x.min() >= -_ROUNDING and x.max() <= 1.0 + _ROUNDING):
        raise InvalidInput(f"u: expected fractions from 0 to 1, got {x.min():.6g} to {x.max():.6g}")
    shape = () if check.rank(height) == 0 else x.shape
    top = check.array(height, "height", shape=shape)
    return np.asarray(top * x**3 * (cubic + quartic * x + quintic * x**2))


def quintic_coefficients(
    start: Float64Array, end: Float64Array, start_slope: Float64Array, end_slope: Float64Array
) -> Float64Array:
    """Coefficients (6, d) of least jerk without acceleration at the ends (Flash and Hogan 1985)."""
    coefficients = np.zeros((6, len(start)))
    coefficients[0] = start
    coefficients[1] = start_slope
    coefficients[3:] = QUINTIC @ np.array((end - start, start_slope, end_slope))
    return coefficients


def minimum_jerk(start: State | ArrayLike, end: State | ArrayLike, *, duration: float) -> Bezier:
    """The least jerk from one state to another: a curve of degree five.

    Args:
        start: a State, or a position (d,) to rest at.
        end: a State, or a position (d,) to rest at.
        duration: s, > 0.

    Source: Grioli 2023, section 2.3.1, with the control points derived anew.
    """
    total = check.number(duration, "duration", above=0.0)
    x0, v0, a0 = checked_state(start, "start", None)
    x1, v1, a1 = checked_state(end, "end", len(x0))
    points = [
        x0,
        x0 + v0 * total / 5.0,
        x0 + 2.0 * v0 * total / 5.0 + a0 * total**2 / 20.0,
        x1 - 2.0 * v1 * total / 5.0 + a1 * total**2 / 20.0,
        x1 - v1 * total / 5.0,
        x1,
    ]
    return Bezier(np.array(points), (0.0, total))


def minimum_jerk_through(
    times: ArrayLike,
    points: ArrayLike,
    *,
    start: State | None = None,
    end: State | None = None,
) -> Spline:
    """The least jerk through points (n, d) at times (n,): quintic pieces that join in C4.

    Args:
        start: velocity and acceleration at the first point, instead of rest; its position is not
            read.
        end: velocity and acceleration at the last point, likewise.

    Raises:
        InvalidInput: if the times are too uneven.
    """
    from scipy.interpolate import make_interp_spline

    t = curve.knot_times(times, "times")
    x = curve.points(points, "points", count=len(t))
    ends = []
    for state, name, row in ((start, "start", x[0]), (end, "end", x[-1])):
        _, v, a = checked_state(row if state is None else state, name, x.shape[1])
        ends.append([(1, v), (2, a)])
    knots = np.concatenate([t[[0] * 6], t[1:-1], t[[-1] * 6]])
    return passing(make_interp_spline(t, x, k=5, t=knots, bc_type=tuple(ends)), t, x)


def checked_state(
    value: State | ArrayLike, name: str, width: int | None
) -> tuple[Float64Array, ...]:
    """Position, velocity and acceleration, (width,) each; a bare position rests."""
    bare = value.position if isinstance(value, State) else value
    position = check.array(bare, f"{name} position", shape=(width or "d",))
    state = value if isinstance(value, State) else State(position)
    return position, state.velocity, state.acceleration


# Phases shorter than this, s, are rounding.
_NO_PHASE = 1e-12
# Beyond these ruckig's quartics lose their digits.
_MAX_NUMBER = 1e6


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
        InvalidInput: if the states are the same or outside the limits.
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
    if np.abs([*first, *last, *rates]).max() > _MAX_NUMBER:
        raise InvalidInput(f"start, end, limits: expected numbers up to {_MAX_NUMBER:g}")
    return _solved(first, last, rates)


def _solved(
    first: tuple[Float64Array, ...], last: tuple[Float64Array, ...], rates: list[Float64Array]
) -> Spline:
    ruckig = check.package("ruckig", extra="ruckig")
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
