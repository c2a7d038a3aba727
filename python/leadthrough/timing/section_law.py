"""The time law of one smooth section of a path."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from leadthrough import _core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, LimitsInfeasible
from leadthrough.timing import bounds, schedule
from leadthrough.timing.request import Request
from leadthrough.timing.samples import Samples, differentiated
from leadthrough.timing.sections import Section
from leadthrough.trajectories import Spline

# Points of the grid over a path: the least, for each of its pieces, and the most.
_POINTS, _POINTS_A_PIECE, _MOST_POINTS = 1000, 8, 50_000
_COARSEST_PERIOD = 1e-3  # s; at lower rates several samples are computed for each one returned
_MOST_SAMPLES = 1e7
# Joints that move by less, rad or m, are at rest: fitting a constant leaves as much.
_AT_REST = 1e-9
# Rounding may take a path beyond its position limits by this, rad or m.
_ROUNDING = 1e-9
# A velocity may deviate from the path by this, relative to its size.
_ALONG = 1e-3
_STATUSES = ("ok", "no_motion", "start_too_fast", "end_too_fast", "too_long", "not_settled")
# Averaging exceeds the bounds of the tip and of efforts by a percent: they are tightened.
_MOST_TIGHTENINGS, _TIGHTER = 10, 1.0 + 1e-4
_JUDGED_SAMPLES = 2000


@dataclass(frozen=True, eq=False)
class _Rates:
    """Limits of the joints that move; zero for those at rest."""

    velocity: Float64Array
    acceleration: Float64Array
    jerk: Float64Array
    scale: Float64Array  # the highest velocity that each could reach


@dataclass(frozen=True, eq=False)
class _Course:
    """What the time law of a section is computed from, apart from the bounds on it."""

    path: _core.TimedPath
    section: Section
    rates: _Rates
    limits: JointLimits
    speeds: tuple[float, float]  # of the path's length, at its ends
    rate: float

    @property
    def parts(self) -> int:
        """Samples computed for each one returned."""
        return max(1, math.ceil(1.0 / (self.rate * _COARSEST_PERIOD) - 1e-9))

    @property
    def period(self) -> float:
        """Time between computed samples, s."""
        return 1.0 / (self.rate * self.parts)

    def law(self, extra: bounds.PathBounds) -> tuple[Float64Array, Float64Array]:
        """Times (n,) and the path's length at them."""
        status, point, length, duration, _, _ = self.path.time_law(
            self.rates.velocity,
            self.rates.acceleration,
            self.rates.jerk,
            extra.fastest,
            extra.gain,
            extra.bend,
            extra.lower,
            extra.upper,
            self.period,
            *self.speeds,
            _MOST_SAMPLES,
        )
        if status:
            raise _failure(_STATUSES[status], self.path.first[point], self.limits)
        if self.speeds[1] == 0.0:
            missing = -(len(length) - 1) % self.parts
            length = np.concatenate([length, np.full(missing, length[-1])])
            duration = self.period * (len(length) - 1)
        times = np.arange(len(length), dtype=np.float64) * self.period
        times[-1] = duration
        return times, length

    def motion(self, extra: bounds.PathBounds) -> Samples:
        """The motion, sampled at the rate asked for."""
        times, length = self.law(extra)
        q = self.path.positions_at(length)
        places = _places(length, self.path, self.section)
        return differentiated(times, places, q, self.path, speeds=self.speeds).thinned(self.parts)


def time_section(
    section: Section,
    limits: JointLimits,
    request: Request,
    *,
    begin: float,
    first: bool,
    last: bool,
) -> Samples:
    """The fastest motion along a section.

    Args:
        section: what it runs along.
        limits: of the joints.
        request: what else it must keep.
        begin: when it begins, s.
        first: whether the section is the path's first, which may start with a velocity.
        last: whether it is the path's last, which may end with one.

    Raises:
        InvalidInput: if the request and the path do not fit each other.
        LimitsInfeasible: if no motion along it keeps the limits.
    """
    rates = _rates(section.spline, limits)
    path = _timed_path(section.spline, rates.scale)
    _check_positions(path, limits)
    speeds = (
        _end_speed(path, 0, request.start_velocity if first else None, "start_velocity"),
        _end_speed(path, -1, request.end_velocity if last else None, "end_velocity"),
    )
    course = _Course(path, section, rates, limits, speeds, request.rate)
    effort_fraction, tip_fraction = 1.0, 1.0
    for _ in range(_MOST_TIGHTENINGS):
        found = _bounds(path, limits, request, effort=effort_fraction, tip=tip_fraction)
        motion = course.motion(_on_schedule(course, found, request, begin))
        tip, effort = _tip_ratio(motion, request), _effort_ratio(motion, limits, request)
        if max(tip, effort) <= 1.0:
            return motion.held(section.hold, request.rate)
        tip_fraction /= max(tip * _TIGHTER, 1.0)
        effort_fraction /= max(effort * _TIGHTER, 1.0)
    raise LimitsInfeasible(
        "no motion along the path keeps the tip's speed and the efforts inside their limits",
        joint=limits.joint_names[0],
    )


def _rates(spline: Spline, limits: JointLimits) -> _Rates:
    spread = np.ptp(spline.evaluate(np.linspace(*spline.domain, 4 * _POINTS // 10)), axis=0)
    moves = spread > _AT_REST
    velocity, acceleration, jerk = limits.velocity, limits.acceleration, limits.jerk
    assert acceleration is not None
    assert jerk is not None
    # A joint that starts and stops within its spread comes to no higher speed than these.
    scale = np.minimum(
        np.minimum(velocity, np.sqrt(acceleration * spread)), np.cbrt(jerk * spread**2)
    )
    for i in np.flatnonzero(moves & ~(scale > 0.0)):
        name = limits.joint_names[i]
        raise LimitsInfeasible(f"{name} moves along the path, but a limit of it is 0", joint=name)
    if not np.isfinite(scale[moves]).any():
        raise InvalidInput("limits: expected a finite limit of some joint that moves, got none")
    still = ~moves | ~np.isfinite(scale)
    return _Rates(
        velocity=np.where(moves, velocity, 0.0),
        acceleration=np.where(moves, acceleration, 0.0),
        jerk=np.where(moves, jerk, 0.0),
        scale=np.where(still, 0.0, scale),
    )


def _timed_path(spline: Spline, scale: Float64Array) -> _core.TimedPath:
    pieces, terms, joints = spline.coefficients.shape
    points = min(max(_POINTS, _POINTS_A_PIECE * pieces), _MOST_POINTS)
    table = spline.coefficients.reshape(pieces * terms, joints)
    return _core.TimedPath(spline.knots, table, scale, points + 1)


def _check_positions(path: _core.TimedPath, limits: JointLimits) -> None:
    lower, upper = limits.lower - _ROUNDING, limits.upper + _ROUNDING
    outside = ((path.positions < lower) | (path.positions > upper)).any(axis=0)
    if outside.any():
        name = limits.joint_names[int(np.argmax(outside))]
        raise LimitsInfeasible(f"{name} leaves its position limits along the path", joint=name)


def _end_speed(path: _core.TimedPath, end: int, velocity: Float64Array | None, name: str) -> float:
    """The speed of the path's length at an end."""
    if velocity is None or not velocity.any():
        return 0.0
    along = path.first[end]
    speed = float(velocity @ along / max(along @ along, 1e-300))
    if speed < 0.0 or np.abs(velocity - speed * along).max() > _ALONG * np.abs(velocity).max():
        raise InvalidInput(f"{name}: expected a velocity along the path, {along}, got {velocity}")
    return speed


def _bounds(
    path: _core.TimedPath,
    limits: JointLimits,
    request: Request,
    *,
    effort: float,
    tip: float,
) -> bounds.PathBounds:
    """The bounds of a request, with fractions of the effort limits and of the tip's speed."""
    found = bounds.unbounded(path)
    if request.tip_speed is not None and request.jacobian is not None:
        speed = tip * request.tip_speed
        found = bounds.slower_than(found, bounds.tip_within(path, request.jacobian, speed))
    if request.inverse_dynamics is not None:
        most = effort * _effort(limits)
        found = bounds.with_efforts(found, path, request.inverse_dynamics, most)
        _check_holding(found, limits)
    return found


def _on_schedule(
    course: _Course, found: bounds.PathBounds, request: Request, begin: float
) -> bounds.PathBounds:
    """The bounds, with the pace of `not_before` where the motion is not late."""
    if request.not_before is None:
        return found
    path, section = course.path, course.section
    times = request.not_before[section.rows]
    shown, pace = bounds.paced(path, section.parameters, times - request.not_before[0])
    due = shown - max(begin, shown[0])

    def bounded(free: schedule.Free) -> bounds.PathBounds:
        return bounds.slower_than(found, np.where(free, np.inf, pace))

    def arrival(free: schedule.Free) -> Float64Array:
        times, length = course.law(bounded(free))
        return np.interp(path.length, length, times)

    return bounded(schedule.hurries(due, arrival, slack=0.5 * course.period))


def _places(length: Float64Array, path: _core.TimedPath, section: Section) -> Float64Array:
    """Places (n,) of a motion, counted in way-points, samples or knots of the whole path."""
    parameters = np.interp(length, path.length, path.parameter)
    places = np.interp(parameters, section.parameters, section.rows)
    places[[0, -1]] = section.rows[[0, -1]]  # exact at the ends, where rounding would miss them
    return places


def _failure(status: str, direction: Float64Array, limits: JointLimits) -> Exception:
    with np.errstate(divide="ignore", invalid="ignore"):
        need = np.nan_to_num(np.abs(direction) / limits.velocity)
    name = limits.joint_names[int(need.argmax())]
    if status == "too_long":
        return InvalidInput(f"rate: expected at most {_MOST_SAMPLES:.0e} samples; lower the rate")
    reasons = {
        "no_motion": "no motion along the path keeps the limits",
        "start_too_fast": "start_velocity is faster than the limits allow",
        "end_too_fast": "end_velocity is faster than the limits allow",
        "not_settled": "no motion with these velocities at the ends keeps the limits",
    }
    return LimitsInfeasible(f"{reasons[status]}; the joint nearest its limit is {name}", joint=name)


def _effort(limits: JointLimits) -> Float64Array:
    if limits.effort is None:
        raise InvalidInput("limits: expected effort limits beside inverse_dynamics, got none")
    return limits.effort


def _check_holding(found: bounds.PathBounds, limits: JointLimits) -> None:
    sinks = (found.lower > 0.0) | (found.upper < 0.0)
    if sinks.any():
        name = limits.joint_names[int(np.argmax(sinks.any(axis=0)))]
        raise LimitsInfeasible(f"{name} cannot hold the arm along the path", joint=name)


def _tip_ratio(motion: Samples, request: Request) -> float:
    if request.tip_speed is None or request.jacobian is None:
        return 0.0
    some = motion.some(_JUDGED_SAMPLES)
    speeds = bounds.tip_speeds(request.jacobian, some.positions, some.velocities)
    return float(speeds.max()) / request.tip_speed


def _effort_ratio(motion: Samples, limits: JointLimits, request: Request) -> float:
    if request.inverse_dynamics is None:
        return 0.0
    some = motion.some(_JUDGED_SAMPLES)
    used = bounds.efforts(
        request.inverse_dynamics, some.positions, some.velocities, some.accelerations
    )
    return float((np.abs(used) / _effort(limits)).max())
