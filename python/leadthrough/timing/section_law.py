"""The time law of one smooth section of a path."""

from __future__ import annotations

import math

import numpy as np

from leadthrough import _core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, LimitsInfeasible
from leadthrough.timing import bounds, schedule
from leadthrough.timing.course import Course, Creeping
from leadthrough.timing.kept import check_positions
from leadthrough.timing.rates import rates_within
from leadthrough.timing.request import Request
from leadthrough.timing.samples import Samples
from leadthrough.timing.sections import Section
from leadthrough.trajectories import Spline

# Points of the grid over a path: the least, for each of its pieces, and the most.
_POINTS, _POINTS_A_PIECE, _MOST_POINTS = 1000, 8, 50_000
_POINTS_OF_SPREAD = 400
# A velocity may deviate from the path by this, relative to its size.
_ALONG = 1e-3
# Parts between pinches may have pinches again; those of parts of parts are passed.
_MOST_CUTS = 4
# A motion is given up that is so many times longer than one without limits of jerk: cut it.
_MOST_DELAY = 20.0
# Averaging exceeds the bounds of the tip and of efforts by a percent: they are tightened.
_MOST_TIGHTENINGS, _TIGHTER = 10, 1.0 + 1e-4
_JUDGED_SAMPLES = 2000


def time_section(section: Section, limits: JointLimits, request: Request, begin: float) -> Samples:
    """The fastest motion along a section, and its rest at the end."""
    motion = _fastest(section, limits, request, begin, cuts=0)
    return motion.held(section.hold, request.rate)


def _fastest(
    section: Section, limits: JointLimits, request: Request, begin: float, *, cuts: int
) -> Samples:
    """The fastest motion along a section that was cut so many times already."""
    last = cuts == _MOST_CUTS
    passing = None
    try:
        passing, pinches = _passing(
            section, limits, request, begin, most_delay=math.inf if last else _MOST_DELAY
        )
    except Creeping as creeping:
        pinches = creeping.pinches
    if passing is not None and (last or len(pinches) == 0):
        return passing
    resting = _resting(section.cut_at(pinches), limits, request, begin, cuts=cuts + 1)
    if passing is not None and passing.times[-1] <= resting.times[-1]:
        return passing
    return resting


def _resting(
    parts: list[Section], limits: JointLimits, request: Request, begin: float, *, cuts: int
) -> Samples:
    """The fastest motion along parts of a section that rests between them."""
    motions = list[Samples]()
    for i, part in enumerate(parts):
        own = request.between_rests(first=i == 0, last=i == len(parts) - 1)
        motions.append(_fastest(part, limits, own, begin, cuts=cuts))
        begin += float(motions[-1].times[-1])
    return Samples.joined(motions)


def _passing(
    section: Section, limits: JointLimits, request: Request, begin: float, *, most_delay: float
) -> tuple[Samples, Float64Array]:
    """The fastest motion along a section that rests nowhere inside, and its pinches."""
    places = np.linspace(*section.spline.domain, _POINTS_OF_SPREAD)
    least, largest = _core.extent(section.spline.evaluate(places))
    rates = rates_within(limits, largest - least)
    path = _timed_path(section.spline, rates.scale)
    check_positions(path.positions, limits)
    speeds = (
        _end_speed(path, 0, request.start_velocity, "start_velocity"),
        _end_speed(path, -1, request.end_velocity, "end_velocity"),
    )
    course = Course(path, section, rates, limits, speeds, request.rate, most_delay)
    effort_fraction, tip_fraction = 1.0, 1.0
    for _ in range(_MOST_TIGHTENINGS):
        found = _bounds(path, limits, request, effort=effort_fraction, tip=tip_fraction)
        law = course.law(_on_schedule(course, found, request, begin))
        motion = course.motion(law)
        tip, effort = _tip_ratio(motion, request), _effort_ratio(motion, limits, request)
        if max(tip, effort) <= 1.0:
            return motion, law.pinches
        tip_fraction /= max(tip * _TIGHTER, 1.0)
        effort_fraction /= max(effort * _TIGHTER, 1.0)
    raise LimitsInfeasible(
        "no motion along the path keeps the tip's speed and the efforts inside their limits",
        joint=limits.joint_names[0],
    )


def _timed_path(spline: Spline, scale: Float64Array) -> _core.TimedPath:
    pieces, terms, joints = spline.coefficients.shape
    points = min(max(_POINTS, _POINTS_A_PIECE * pieces), _MOST_POINTS)
    table = spline.coefficients.reshape(pieces * terms, joints)
    return _core.TimedPath(spline.knots, table, scale, points + 1)


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
    course: Course, found: bounds.PathBounds, request: Request, begin: float
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
        law = course.law(bounded(free))
        return np.interp(path.length, law.length, law.times)

    return bounded(schedule.hurries(due, arrival, slack=0.5 * course.period))


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
