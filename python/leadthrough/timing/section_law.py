"""The time law of one smooth section of a path, and of straight lines with rests between them.

Along a path of length l, with x = (dl/dt)^2 and u = d2l/dt2, every row of a table of bounds says
lower <= gain u + bend x <= upper; see Pham and Pham 2018, section III. An earlier timing bounds x
as well: while the motion is on time, the given pace is the fastest allowed; once limits have made
it late, the pace is free until the motion is on time again. That point is found by bisection, as
the limits also bound how fast the pace changes.

Along lines it has a closed form: a jump averaged over three windows of time, whose widths bound
velocity, acceleration and jerk. It is the fastest motion of samples that keep the limits, to a few
samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm.limits import JointLimits, known_rates, refuse_zeros
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible
from leadthrough.timing.limits_report import MAX_SAMPLES, check_positions, check_samples
from leadthrough.timing.request import Jacobian, Request
from leadthrough.timing.sections import Lines, Section
from leadthrough.timing.torques import torque_ratios, torque_rows
from leadthrough.trajectories import Spline

# Points of the grid over a path: the fewest, for each of its pieces, and the most.
_MIN_POINTS, _POINTS_A_PIECE, _MAX_POINTS = 1000, 8, 50_000
_POINTS_A_SAMPLE = 4  # that has a time of its own: on coarser grids slow parts come early
_POINTS_OF_SPREAD = 400
_COARSE = 1.01  # ratio of speeds from which on a grid is too coarse for them
# If all joints move slightly, those moving by less than this fraction of the most are at rest.
_FRACTION_AT_REST = 1e-3
# An end passed at less than this, of the path's length per s, is at rest.
_SPEED_AT_REST = 1e-9
_CELLS = 4.0  # that the grid has at least where an end is passed at its speed
# A velocity may deviate from the path by this, relative to its size.
_ALONG = 1e-3
# Parts between bottlenecks may have bottlenecks again; those of parts of parts are passed.
_MAX_CUTS = 4
# A motion is given up that is so many times longer than one without limits of jerk: cut it.
_MAX_DELAY = 20.0
# Averaging exceeds the bounds of the tip and of efforts by a percent: they are tightened.
_MAX_TIGHTENINGS, _TIGHTER = 10, 1.0 + 1e-4
_JUDGED_SAMPLES = 2000
_COARSEST_PERIOD = 1e-3  # s; at lower rates several samples are computed for each one returned
_SAME_PARAMETER = 1e-9  # relative to the section
# A motion counts as late by this fraction of its given duration; less is not made up for.
_LATE = 5e-3
_MAX_HURRIES = 20
# Points between two attempts, where the motion is late but any faster pace comes early at once.
_HURRY_SPACING = 10
_STATUSES = (
    "ok",
    "no_motion",
    "start_too_fast",
    "end_too_fast",
    "too_long",
    "not_settled",
    "slow_profile",
)

# Joints that move by less, rad or m, are at rest: fitting a constant leaves as much.
AT_REST = 1e-9

Free = NDArray[np.bool_]


def time_section(
    section: Section, limits: JointLimits, request: Request, begin: float, *, cuts: int = 0
) -> Samples:
    """The fastest motion along a section that was cut so many times already."""
    last = cuts == _MAX_CUTS
    passing = None
    try:
        passing, bottlenecks = _passing(
            section, limits, request, begin, max_delay=math.inf if last else _MAX_DELAY
        )
    except SlowProfile as slow:
        bottlenecks = slow.bottlenecks
    if passing is not None and (last or len(bottlenecks) == 0):
        return passing
    resting = _resting(section.cut_at(bottlenecks), limits, request, begin, cuts=cuts + 1)
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
        motions.append(time_section(part, limits, own, begin, cuts=cuts))
        begin += float(motions[-1].times[-1])
    return Samples.joined(motions)


def _passing(
    section: Section, limits: JointLimits, request: Request, begin: float, *, max_delay: float
) -> tuple[Samples, Float64Array]:
    """The fastest motion along a section that rests nowhere inside, and its bottlenecks."""
    q = section.spline.evaluate(np.linspace(*section.spline.domain, _POINTS_OF_SPREAD))
    rates = _rates_within(limits, q.max(axis=0) - q.min(axis=0))
    points = 0 if request.earliest_times is None else _POINTS_A_SAMPLE * len(section.rows)
    path = _timed_path(section.spline, rates.scale, points=points)
    check_positions(path.positions, limits)
    speeds = _end_speed(path, 0, request), _end_speed(path, -1, request)
    if ends := _slow_ends(path, speeds, rates):
        path = _timed_path(section.spline, rates.scale, points=points, also=ends)
        speeds = _end_speed(path, 0, request), _end_speed(path, -1, request)
    problem = TimingProblem(path, section, rates, limits, speeds, request.rate, max_delay)
    effort_fraction, tip_fraction = np.ones(len(limits.joint_names)), 1.0
    for harder in range(1, _MAX_TIGHTENINGS + 1):
        bounds = _bounds(path, rates, limits, request, effort=effort_fraction, tip=tip_fraction)
        law = problem.law(_on_schedule(problem, bounds, request, begin))
        motion = problem.motion(law)
        tip, effort = _ratios(motion.some(_JUDGED_SAMPLES), limits, request)
        if max(tip, *effort) <= 1.0:
            return motion, law.bottlenecks
        tip_fraction /= max(tip * _TIGHTER, 1.0) ** harder
        effort_fraction /= np.maximum(effort * _TIGHTER, 1.0) ** harder
    raise LimitsInfeasible(
        "no motion along the path keeps the tip's speed and the efforts inside their limits",
        joint=limits.joint_names[0],
    )


def _timed_path(
    spline: Spline, scale: Float64Array, *, points: int, also: Sequence[float] = ()
) -> core.TimedPath:
    pieces, terms, joints = spline.coefficients.shape
    points = min(max(points, _MIN_POINTS, _POINTS_A_PIECE * pieces), _MAX_POINTS)
    table = spline.coefficients.reshape(pieces * terms, joints)
    return core.TimedPath(spline.knots, table, scale, points + 1, np.array(also, np.float64))


def _slow_ends(path: core.TimedPath, speeds: tuple[float, float], rates: _Rates) -> list[float]:
    """Parameters near ends that are passed, while averaging goes on, in less than a cell."""
    bound = rates.jerk > 0.0
    window = float(np.sqrt(rates.scale[bound] / rates.jerk[bound]).max(initial=0.0))
    passed = window / _CELLS * np.array(speeds)
    slow = (passed > 0.0) & (passed < np.diff(path.length)[[0, -1]])
    at = path.parameter[[0, -1]] + np.array([1.0, -1.0]) * passed * path.slope[[0, -1]]
    return at[slow].tolist()  # type: ignore[no-any-return]


def _end_speed(path: core.TimedPath, end: int, request: Request) -> float:
    """The speed of the path's length at an end."""
    name = ("start_velocity", "end_velocity")[end]
    velocity: Float64Array | None = getattr(request, name)
    if velocity is None or not velocity.any():
        return 0.0
    along, size = path.first[end], float(np.linalg.norm(velocity))
    if size <= _SPEED_AT_REST * path.length[-1] * np.linalg.norm(along):
        return 0.0
    speed = float(velocity @ along / max(along @ along, 1e-300))
    if speed < 0.0 or np.abs(velocity - speed * along).max() > _ALONG * np.abs(velocity).max():
        raise InvalidInput(f"{name}: expected a velocity along the path, {along}, got {velocity}")
    return speed


@dataclass(frozen=True, eq=False)
class _Rates:
    """Limits (joints,) along a path, and the speeds that joints could come to; zero at rest."""

    velocity: Float64Array  # rad/s (m/s)
    acceleration: Float64Array  # rad/s^2 (m/s^2)
    jerk: Float64Array  # rad/s^3 (m/s^3)
    scale: Float64Array


def _rates_within(limits: JointLimits, spread: Float64Array) -> _Rates:
    """The rates along a path."""
    velocity, acceleration, jerk = known_rates(limits)
    # An infinite limit times no spread would be no number.
    some = np.maximum(spread, np.finfo(np.float64).tiny)
    # A joint that starts and stops within its spread comes to no higher speed than these.
    scale = np.minimum(
        np.minimum(velocity, np.sqrt(acceleration * some)), np.cbrt(jerk) * np.cbrt(some) ** 2
    )
    moves = spread > min(AT_REST, _FRACTION_AT_REST * spread.max())
    refuse_zeros(limits, moves)
    if not np.isfinite(scale[moves]).any():
        raise InvalidInput("limits: expected a finite limit of some joint that moves, got none")
    bound = (scale > 0.0) & (spread > 0.0)
    return _Rates(
        velocity=np.where(bound, velocity, 0.0),
        acceleration=np.where(bound, acceleration, 0.0),
        jerk=np.where(bound, jerk, 0.0),
        scale=np.where(moves & np.isfinite(scale), scale, 0.0),
    )


class SlowProfile(Exception):
    """The motion takes far longer than its profile, for its bottlenecks."""

    def __init__(self, bottlenecks: Float64Array) -> None:
        super().__init__()
        self.bottlenecks = bottlenecks


@dataclass(frozen=True, eq=False)
class _Law:
    times: Float64Array  # s, (n,)
    length: Float64Array  # the path's length at them, (n,)
    speed: Float64Array  # its derivative in time, (n,)
    push: Float64Array  # its second derivative, (n,)
    bottlenecks: Float64Array  # parameters at which a rest may be faster than passing


@dataclass(frozen=True, eq=False)
class TimingProblem:
    """All that the time law of a section is computed from, apart from the bounds on it."""

    path: core.TimedPath  # the path and its grid
    section: Section  # what it is the path of
    rates: _Rates  # of the joints along it
    limits: JointLimits  # of the joints
    speeds: tuple[float, float]  # of the path's length, at its ends
    rate: float  # samples per second
    max_delay: float

    @property
    def parts(self) -> int:
        """Samples computed for each one returned."""
        return max(1, math.ceil(1.0 / (self.rate * _COARSEST_PERIOD) - 1e-9))

    @property
    def period(self) -> float:
        """Time between computed samples, s."""
        return 1.0 / (self.rate * self.parts)

    def law(self, bounds: _PathBounds) -> _Law:
        """The time law inside the bounds."""
        status, point, length, speed, push, duration, _, _, points = self.path.law(
            self.rates.velocity,
            self.rates.acceleration,
            self.rates.jerk,
            bounds.fastest,
            bounds.gain,
            bounds.bend,
            bounds.lower,
            bounds.upper,
            self.period,
            self.parts,
            *self.speeds,
            MAX_SAMPLES,
            self.max_delay,
        )
        bottlenecks = self.path.parameter[points]
        if status and len(bottlenecks):
            raise SlowProfile(bottlenecks)
        if status:
            raise _failure(_STATUSES[status], self.path.first[point], self.limits)
        if self.speeds[1] == 0.0:
            missing = np.zeros(-(len(length) - 1) % self.parts)
            length = np.concatenate([length, missing + length[-1]])
            speed, push = (np.concatenate([values, missing]) for values in (speed, push))
            duration = self.period * (len(length) - 1)
        times = np.arange(len(length), dtype=np.float64) * self.period
        times[-1] = duration
        return _Law(times, length, speed, push, bottlenecks)

    def motion(self, law: _Law) -> Samples:
        """The motion of a law, sampled at the rate asked for, with its own derivatives."""
        rows = _thinned(len(law.times), self.parts)
        length = law.length[rows]
        states = self.path.states_along(length, law.speed[rows], law.push[rows])
        return Samples(law.times[rows], _rows_at(length, self.path, self.section), *states)


def _thinned(count: int, parts: int) -> NDArray[np.intp]:
    """Every sample of `parts` and the last; one half a step or less before it is left out."""
    last = count - 1
    rows = np.arange(0, last, parts)
    if len(rows) > 1 and last - rows[-1] < 0.5 * parts:
        rows = rows[:-1]
    return np.append(rows, last)


def _rows_at(length: Float64Array, path: core.TimedPath, section: Section) -> Float64Array:
    """Progress (n,) of a motion, counted in way-points, samples or knots of the whole path."""
    parameters = np.interp(length, path.length, path.parameter)
    rows = np.interp(parameters, section.parameters, section.rows)
    # Exact at the ends of the whole, where rounding would miss them.
    near = _SAME_PARAMETER * float(section.parameters[-1] - section.parameters[0])
    for end in (0, -1):
        if abs(path.parameter[end] - section.parameters[end]) <= near:
            rows[end] = section.rows[end]
    return rows


def _failure(status: str, direction: Float64Array, limits: JointLimits) -> Exception:
    with np.errstate(divide="ignore", invalid="ignore"):
        need = np.nan_to_num(np.abs(direction) / limits.velocity)
    name = limits.joint_names[int(need.argmax())]
    if status == "too_long":
        check_samples(math.inf)
    reasons = {
        "no_motion": "no motion along the path keeps the limits",
        "start_too_fast": "start_velocity is faster than the limits allow",
        "end_too_fast": "end_velocity is faster than the limits allow",
        "not_settled": "no motion with these velocities at the ends keeps the limits",
    }
    return LimitsInfeasible(f"{reasons[status]}; the joint nearest its limit is {name}", joint=name)


@dataclass(frozen=True, eq=False)
class _PathBounds:
    """Bounds at the n points of a path's grid."""

    fastest: Float64Array  # the largest x, (n,)
    gain: Float64Array  # factor of u in each row of the table, (n, rows)
    bend: Float64Array  # factor of x, (n, rows)
    lower: Float64Array  # lower bound of the row, (n, rows)
    upper: Float64Array  # upper bound of the row, (n, rows)

    def slower_than(self, squared: Float64Array) -> _PathBounds:
        """The bounds, with x at most `squared` (n,)."""
        return replace(self, fastest=np.minimum(self.fastest, squared))


def _bounds(
    path: core.TimedPath,
    rates: _Rates,
    limits: JointLimits,
    request: Request,
    *,
    effort: Float64Array,
    tip: float,
) -> _PathBounds:
    """The bounds of a request, with fractions of the tip's speed and of what holding leaves."""
    count = len(path.length)
    empty = np.empty((count, 0))
    bounds = _PathBounds(np.full(count, np.inf), empty, empty, empty, empty)
    if request.tip_speed is not None:
        speeds = _tip_speeds(request.tip_speed.jacobian, path.positions, path.first)
        with np.errstate(divide="ignore"):
            bounds = bounds.slower_than((tip * request.tip_speed.limit / speeds) ** 2)
    if request.inverse_dynamics is not None:
        rows = torque_rows(path, rates.scale, request.inverse_dynamics, limits, effort)
        bounds = _PathBounds(bounds.fastest, *rows)
    return bounds


def _ratios(some: Samples, limits: JointLimits, request: Request) -> tuple[float, Float64Array]:
    """Fractions of the tip's speed, and of the efforts (joints,), that a motion needs."""
    states = some.positions, some.velocities, some.accelerations
    tip, effort = 0.0, np.zeros(some.positions.shape[1])
    if request.tip_speed is not None:
        speeds = _tip_speeds(request.tip_speed.jacobian, *states[:2])
        tip = float(speeds.max()) / request.tip_speed.limit
    if request.inverse_dynamics is not None:
        effort = torque_ratios(request.inverse_dynamics, limits, *states)
    return tip, effort


def _tip_speeds(jacobian: Jacobian, q: Float64Array, velocities: Float64Array) -> Float64Array:
    """Speeds (n,) of the tip, m/s, at configurations and velocities (n, joints)."""
    speeds = []
    for row, velocity in zip(q, velocities, strict=True):
        matrix = check.array(jacobian(row), "jacobian(q)", shape=("rows", len(row)))
        speeds.append(np.linalg.norm(matrix[:3] @ velocity))
    return np.array(speeds)


def _on_schedule(
    problem: TimingProblem, bounds: _PathBounds, request: Request, begin: float
) -> _PathBounds:
    """The bounds, with the pace of the earliest times where the motion is not late."""
    if request.earliest_times is None:
        return bounds
    path, section = problem.path, problem.section
    times = request.earliest_times[section.rows]
    given, pace = _paced(path, section.parameters, times - request.earliest_times[0])
    due = given - max(begin, given[0])

    def bounded(free: Free) -> _PathBounds:
        return bounds.slower_than(np.where(free, np.inf, pace))

    def arrival(free: Free) -> Float64Array:
        law = problem.law(bounded(free))
        return np.interp(path.length, law.length, law.times)

    return bounded(hurries(due, arrival, slack=0.5 * problem.period))


def _paced(
    path: core.TimedPath, parameters: Float64Array, times: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Times (n,) at the grid's points, and x (n,) there, of a motion known at some parameters."""
    from scipy.interpolate import PchipInterpolator

    clock = PchipInterpolator(parameters, times)
    given = clock(path.parameter)
    with np.errstate(divide="ignore"):
        speed = 1.0 / clock(path.parameter, 1) / path.slope
    # Between two points the speed is their mean: beside a pause it would leave out the pause.
    mean = np.diff(path.length) / np.diff(given)
    least = np.where(0.5 * (speed[:-1] + speed[1:]) > _COARSE * mean, mean, np.inf)
    capped = np.minimum.reduce([speed, np.append(least, np.inf), np.append(np.inf, least)])
    return given, capped**2


def hurries(due: Float64Array, arrival: Callable[[Free], Float64Array], *, slack: float) -> Free:
    """Samples (n,) of a path with a free pace, so that the motion catches up."""
    free = np.zeros(len(due), dtype=np.bool_)
    late = arrival(free) - due
    allowed = min(float(late.min()), 0.0) - slack
    too_late = max(_LATE * float(due[-1] - due[0]), 4.0 * slack)
    begin = 0
    for _ in range(_MAX_HURRIES):
        points = np.flatnonzero(late[begin:] > too_late)
        if not len(points):
            break
        first = begin + int(points[0])
        end, limiting = _end(free, first, lambda some: arrival(some) - due, allowed)
        free[first:end] = True
        late = arrival(free) - due
        # Whatever is freed before the point that limits this one would bring it early too.
        begin = max(end, limiting, first + _HURRY_SPACING)
    return free


def _end(
    free: Free, first: int, lateness: Callable[[Free], Float64Array], allowed: float
) -> tuple[int, int]:
    """The point up to which the pace may be free from the first one, and what limits it."""
    low, high, end, limiting = first, len(free) + 1, len(free), len(free)
    while high - low > 1:
        trial = free.copy()
        trial[first:end] = True
        # Also before the first point: the motion need not slow down to a slow pace that it was to.
        early = np.flatnonzero(lateness(trial) < allowed)
        if len(early):
            high, limiting = end, int(early[0])
        else:
            low = end
        end = (low + high) // 2
    return low, limiting


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a motion."""

    times: Float64Array  # s from the start, (n,)
    rows: Float64Array  # progress, counted in way-points, samples or knots of the path, (n,)
    positions: Float64Array  # rad (m), (n, joints)
    velocities: Float64Array  # rad/s (m/s), (n, joints)
    accelerations: Float64Array  # rad/s^2 (m/s^2), (n, joints)

    @staticmethod
    def at_rest(
        q: Float64Array, time: float = 0.0, rate: float = 1.0, rows: tuple[float, float] = (0, 0)
    ) -> Samples:
        """Samples at rest at a configuration (joints,), while the progress goes on."""
        check_samples(time * rate)
        count = math.ceil(time * rate - 1e-9) + 1
        still = np.zeros((count, len(q)))
        progress = np.linspace(*rows, count)
        return Samples(
            np.arange(count) / rate, progress, np.repeat(q[None], count, 0), still, still
        )

    @staticmethod
    def joined(motions: Sequence[Samples]) -> Samples:
        """All motions; each begins where the one before ends."""
        if len(motions) == 1:
            return motions[0]
        ends = np.cumsum([0.0, *(motion.times[-1] for motion in motions[:-1])])
        cut = [slice(int(i > 0), None) for i in range(len(motions))]
        pairs = list(zip(motions, cut, strict=True))
        times = [end + m.times[c] for end, (m, c) in zip(ends, pairs, strict=True)]
        others = ([vars(m)[name][c] for m, c in pairs] for name in list(vars(motions[0]))[1:])
        return Samples(np.concatenate(times), *map(np.concatenate, others))

    def with_dwells(self, at: NDArray[np.intp], times: Float64Array, rate: float) -> Samples:
        """The motion with further rests at samples."""
        copies = np.ones(len(self.times), dtype=np.intp)
        check_samples(float(times.sum()) * rate)
        copies[at] += np.ceil(times * rate - 1e-9).astype(np.intp)
        if (copies == 1).all():
            return self
        later = np.concatenate([[0], np.cumsum(copies[:-1] - 1)]) / rate
        repeated = self._of(np.repeat(np.arange(len(self.times)), copies))
        within = np.arange(len(repeated.times)) - np.repeat(np.cumsum(copies) - copies, copies)
        return replace(repeated, times=repeated.times + np.repeat(later, copies) + within / rate)

    def some(self, count: int) -> Samples:
        """At most `count` evenly spread samples."""
        return self._of(np.unique(np.linspace(0, len(self.times) - 1, count).astype(np.intp)))

    def _of(self, index: NDArray[np.intp]) -> Samples:
        return Samples(*(column[index] for column in vars(self).values()))


def time_lines(lines: Lines, limits: JointLimits, rate: float) -> Samples:
    """The fastest motion along lines, with its rests."""
    velocity, acceleration, jerk = known_rates(limits)
    changes = np.diff(lines.ends, axis=0)
    bound = (velocity > 0.0) & (acceleration > 0.0) & (jerk > 0.0)
    _check_limits(limits, np.abs(changes), bound)
    failed, steps, shares = core.time_lines(
        np.ascontiguousarray(lines.ends),
        np.where(bound, velocity, 0.0),
        np.where(bound, acceleration, 0.0),
        np.where(bound, jerk, 0.0),
        1.0 / rate,
        MAX_SAMPLES,
    )
    if failed >= 0:
        check_samples(math.inf)
    line = np.repeat(np.arange(len(steps)), steps)
    rests = np.cumsum(np.concatenate([[0], steps]))
    share, speed, push = (column[:, None] for column in np.vstack([np.zeros((1, 3)), shares]).T)
    line = np.concatenate([[0], line])
    q = lines.ends[line] + share * changes[line]
    q[rests] = lines.ends
    length = lines.at[line] + share[:, 0] * np.diff(lines.at)[line]
    motion = Samples(
        np.arange(len(q)) / rate,
        np.interp(length, lines.lengths, lines.rows),
        q,
        speed * changes[line] * rate,
        push * changes[line] * rate**2,
    )
    return motion.with_dwells(rests[1:], lines.dwell_times, rate)


def _check_limits(limits: JointLimits, moved: Float64Array, bound: NDArray[np.bool_]) -> None:
    refuse_zeros(limits, moved.max(axis=0) > AT_REST)
    least = np.minimum.reduce(known_rates(limits))
    if not ((moved > 0.0) & bound & np.isfinite(least)).any(axis=1).all():
        raise InvalidInput("limits: expected a finite limit of some joint that moves, got none")
