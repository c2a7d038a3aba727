"""The time law of a motion inside velocity, acceleration and jerk limits.

The time-optimal speeds for velocities and accelerations are those of Pham and Pham 2018 in their
interpolation scheme. Averaging them over two windows of time bounds the jerk; where averaging
pushes a joint over a limit, the path is passed a little more slowly, there and nowhere else, and
where passing a narrow turn would take longer, the motion rests there. Straight lines between rests
have a closed form. The samples carry the law's own derivatives. The output is verified: it
satisfies `check_limits`, or an error is raised.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm.limits import JointLimits
from leadthrough.check import InvalidInput, LimitsInfeasible
from leadthrough.motion import JointTrajectory, computed_joints, in_order, moved_events
from leadthrough.timing import limits_report, request as checks
from leadthrough.timing.limits_report import KINDS
from leadthrough.timing.request import InverseDynamics, Request, TipSpeed, TipTolerance
from leadthrough.timing.section_law import Samples, time_lines, time_section
from leadthrough.timing.sections import Lines, Path, Section, Sections, path_of
from leadthrough.trajectories import Curve

# Short sections lose digits: where that shows, the path is timed again, slightly slower.
_MAX_ATTEMPTS = 4
_TIGHTER = 0.999
_MIN_RATE = 1e-3  # 1/s; the law is computed a thousand times a second, or more
# Windows of so many samples choose the tolerance of a long path: a wider one has to make them
# faster by this part: the gain of the whole motion differs, and must not become a loss.
_LONG, _WINDOWS, _WINDOW, _WORTH = 20_000, 4, 1000, 0.98
# A path that leaves the position limits by so much is bounded by this much more inside them.
_INSIDE = 1.5
_EXACT = 1e-6  # of a step between samples, by which their times may round
PathT = TypeVar("PathT")


def retime(
    path: JointTrajectory | Curve | ArrayLike,
    limits: JointLimits,
    *,
    rate: float = 1000.0,
    path_tolerance: float | TipTolerance = 1e-5,
    blend: float = 0.0,
    dwell_times: Mapping[int, float] | None = None,
    start_velocity: ArrayLike | None = None,
    end_velocity: ArrayLike | None = None,
    tip_speed: TipSpeed | None = None,
    inverse_dynamics: InverseDynamics | None = None,
) -> JointTrajectory:
    """The fastest motion along a path inside the limits, from rest to rest, evenly sampled.

    Args:
        path: a JointTrajectory, through whose samples a smooth path is fitted; a curve of
            `leadthrough.trajectories`, of which a Spline with two continuous derivatives is
            followed exactly and one with corners rests at them; or way-points (n, joints), joined
            by straight lines; those within 1e-9 rad (m) of each other are one. Its rows are its
            samples, knots or way-points.
        limits: velocity, acceleration and jerk limits of the joints.
        rate: samples per second, >= 0.001.
        path_tolerance: how far a fitted path may lie off the samples, rad (m), or a TipTolerance.
            Of smooth paths within tolerances up to this one, the fastest is taken: more never takes
            longer.
        blend: rad (m), by how much corners between way-points are cut; with 0 the motion rests
            there, as it may where a cut would be so narrow that resting is faster.
        dwell_times: seconds that the motion rests, by row.
        start_velocity: velocity (joints,) along the path at its start, instead of rest.
        end_velocity: velocity (joints,) along the path at its end, instead of rest; the last step
            may then be shorter or longer than the others by half.
        tip_speed: the largest speed of the tip at the samples, and between them within 1 % from
            50 Hz on.
        inverse_dynamics: maps q, velocities and accelerations to efforts, such as
            `arm.motor_torques`; with it, the efforts satisfy their limits at the samples as well,
            and between them within 2 % from 100 Hz on.

    Returns:
        Samples at `rate`, with the velocities and accelerations of the time law, so that the
        quintics between them satisfy the limits as `check_limits` judges them. A trajectory's
        events stay where they are on the path. Its clock goes on from the path's first time; from 0
        where that, as a time since 1970, is too large to tell the samples apart exactly.

    Raises:
        LimitsInfeasible: if a position lies outside its limits, a joint moves whose limit is 0, a
            velocity at an end is too fast, the arm cannot hold itself, or the motion found exceeds
            a limit by more than 1e-6 of it.

    Source: Pham and Pham 2018.
    """
    path = _named(path, limits, "path")
    route = _route(path, limits)
    request = Request(
        rate=check.number(rate, "rate", at_least=_MIN_RATE),
        lower=limits.lower,
        upper=limits.upper,
        path_tolerance=checks.joint_tolerance(path_tolerance, route.joints),
        blend=check.number(blend, "blend", at_least=0.0),
        dwell_times=checks.checked_dwell_times(dwell_times, route.rows),
        start_velocity=checks.checked_velocity(start_velocity, "start_velocity", route.joints),
        end_velocity=checks.checked_velocity(end_velocity, "end_velocity", route.joints),
        tip_speed=checks.checked_tip_speed(tip_speed),
        inverse_dynamics=checks.checked_dynamics(inverse_dynamics),
    )
    if not isinstance(path, JointTrajectory):
        return _timed(route, route.sections(request), path, limits, request)
    tip = path_tolerance if isinstance(path_tolerance, TipTolerance) else None
    if len(path) > _LONG:
        return _timed_as_its_windows(path, limits, request, tip)
    return min(_within(path, limits, request, tip), key=lambda motion: motion.duration)


def _within(
    path: JointTrajectory, limits: JointLimits, request: Request, tip: TipTolerance | None
) -> Iterator[JointTrajectory]:
    """Motions along smoother and smoother paths, as far as the tolerance allows."""
    route = path_of(path)
    for i, each in enumerate(request.smoother(endless=tip is not None)):
        sections = route.sections(each)
        if i > 0 and not _is_allowed(sections, path, each, tip):
            return
        try:
            motion = _timed(route, sections, path, limits, each)
        except LimitsInfeasible:
            if i == 0:
                raise
            return  # a smooth path may leave position limits that the samples touch
        yield motion


def _timed_as_its_windows(
    path: JointTrajectory, limits: JointLimits, request: Request, tip: TipTolerance | None
) -> JointTrajectory:
    """The motion along the path that is worth it in windows of a long path, or the next smooth."""
    inner = replace(request.between_rests(first=False, last=False), dwell_times={})
    columns = [
        [motion.duration for motion in _within(window, limits, inner, tip)]
        for window in _windows(path)
    ]
    rungs, route = request.smoother(endless=tip is not None), path_of(path)
    for i in reversed(_worth_it([sum(row) for row in zip(*columns, strict=False)])[1:]):
        sections = route.sections(rungs[i])
        if _is_allowed(sections, path, rungs[i], tip):
            with suppress(LimitsInfeasible):
                return _timed(route, sections, path, limits, rungs[i])
    return _timed(route, route.sections(rungs[0]), path, limits, rungs[0])


def _windows(path: JointTrajectory) -> list[JointTrajectory]:
    lengths = np.cumsum(np.linalg.norm(np.diff(path.positions, axis=0), axis=1))
    middles = np.searchsorted(lengths, lengths[-1] * (np.arange(_WINDOWS) + 0.5) / _WINDOWS)
    starts = np.clip(middles - _WINDOW // 2, 0, len(path) - _WINDOW)
    return [path[start : start + _WINDOW] for start in starts.tolist()]


def _worth_it(durations: Sequence[float]) -> list[int]:
    """The first duration, and those that are shorter than the one before by a clear part."""
    worth = [0]
    for i, duration in enumerate(durations):
        if duration < _WORTH * durations[worth[-1]]:
            worth.append(i)
    return worth


def _is_allowed(
    sections: Sections, path: JointTrajectory, request: Request, tip: TipTolerance | None
) -> bool:
    """Whether a tolerance at the tip, if there is one, allows the fitted path."""
    parts = [part for part in sections.parts if isinstance(part, Section)]
    off = (part.spline.evaluate(part.parameters) - path.positions[part.rows] for part in parts)
    return tip is None or all(tip.allows(np.abs(each) + request.dropped) for each in off)


def keep_timing(
    motion: JointTrajectory | Curve,
    limits: JointLimits,
    *,
    rate: float = 1000.0,
    path_tolerance: float | TipTolerance = 1e-5,
    dwell_times: Mapping[int, float] | None = None,
    tip_speed: TipSpeed | None = None,
    inverse_dynamics: InverseDynamics | None = None,
) -> JointTrajectory:
    """The motion with its own timing, slowed down locally where the limits require it.

    No sample, or knot of a curve, is reached earlier than it was given. If limits have made the
    motion late by half a percent of its duration or more, it is faster than given only until it is
    on time again. Arguments that are not listed are as of `retime`.

    Args:
        motion: a JointTrajectory, or a curve whose parameter is the time in s.
        dwell_times: seconds that the motion rests in addition, by sample or knot.

    Returns:
        Samples at `rate`, with their velocities and accelerations, as of `retime`.

    Raises:
        LimitsInfeasible: as from `retime`.
    """
    check.instance(motion, "motion", JointTrajectory | Curve, "a JointTrajectory or a curve")
    motion = _named(motion, limits, "motion")
    route = _route(motion, limits)
    request = Request(
        rate=check.number(rate, "rate", at_least=_MIN_RATE),
        lower=limits.lower,
        upper=limits.upper,
        path_tolerance=checks.joint_tolerance(path_tolerance, route.joints),
        dwell_times=checks.checked_dwell_times(dwell_times, route.rows),
        earliest_times=motion.times if isinstance(motion, JointTrajectory) else motion.knots,
        tip_speed=checks.checked_tip_speed(tip_speed),
        inverse_dynamics=checks.checked_dynamics(inverse_dynamics),
    )
    return _timed(route, route.sections(request), motion, limits, request)


def _named(path: PathT, limits: JointLimits, argument: str) -> PathT:
    """The path with its joints in the order of the limits, where it names them."""
    check.instance(limits, "limits", JointLimits, "JointLimits, as arm.limits")
    if not isinstance(path, JointTrajectory):
        return path
    return cast(PathT, in_order(path, limits.joint_names, argument))  # of the same type


def _route(path: JointTrajectory | Curve | ArrayLike, limits: JointLimits) -> Path:
    """The path, if the limits are as many as its joints."""
    missing = [name for name in ("acceleration", "jerk") if getattr(limits, name) is None]
    if missing:
        raise InvalidInput(
            f"limits: expected {' and '.join(missing)} limits, got none; "
            "`leadthrough info --write-limits` writes a file with assumed ones; in Python, "
            f"Arm.from_urdf takes a file of limits:\n{limits.template()}"
        )
    route = path_of(path)
    if route.joints != len(limits.joint_names):
        raise check.refused("limits", f"limits of {route.joints} joints", len(limits.joint_names))
    return route


def _timed(
    route: Path,
    sections: Sections,
    path: JointTrajectory | Curve | ArrayLike,
    limits: JointLimits,
    request: Request,
) -> JointTrajectory:
    """The motion over all sections, with the rests between them; it satisfies the limits."""
    inner = limits
    for _ in range(_MAX_ATTEMPTS):
        motion = _joined(route, sections, inner, request)
        timed = _trajectory(motion, path, limits.joint_names)
        used = limits_report.extremes(timed, request.rests_at_ends)
        outside = limits_report.positions_outside(used, limits)
        if outside.any():  # between samples, or a smooth path near them
            request = request.inside(_INSIDE * outside)
            sections = route.sections(request)
            continue
        report = limits_report.report_of(used, limits, timed.times)
        kind, peak = max(((k, getattr(report, k)) for k in KINDS), key=lambda each: each[1].ratio)
        if peak.ratio <= 1.0 + limits_report.ROUNDING:
            return timed
        limit = getattr(inner, kind) * (_TIGHTER / peak.ratio)
        inner = replace(inner, **{kind: limit})
    limits_report.check_positions(used.positions, limits)
    raise LimitsInfeasible(
        f"no motion was found that satisfies the limits: {peak.joint} would reach "
        f"{peak.ratio:.6g} times its {kind} limit at {peak.time:.6g} s; please report this path",
        joint=peak.joint,
    )


def _joined(route: Path, sections: Sections, limits: JointLimits, request: Request) -> Samples:
    """The motions along the sections, one after the other, with rests until the next is due."""
    rows = [*(int(part.rows[0]) for part in sections.parts), route.rows - 1]
    begins = begin = max(sections.initial_dwell, request.due(rows[0]))
    motions = [Samples.at_rest(route.start, begin, request.rate, (0, rows[0]))]
    for i, part in enumerate(sections.parts):
        if isinstance(part, Lines):
            motions.append(time_lines(part, limits, request.rate))
            continue
        own = request.between_rests(first=i == 0, last=i == len(sections.parts) - 1)
        motions.append(motion := time_section(part, limits, own, begin))
        begin += float(motion.times[-1])
        left = max(part.dwell_time, request.due(rows[i + 1]) - begin)
        if left > 0.0:
            passed = float(motion.rows[-1]), rows[i + 1]
            motions.append(Samples.at_rest(motion.positions[-1], left, request.rate, passed))
            begin += float(motions[-1].times[-1])
    return Samples.joined(motions[1:] if len(motions) > 1 and begins == 0.0 else motions)


def _trajectory(
    motion: Samples, path: JointTrajectory | Curve | ArrayLike, names: tuple[str, ...]
) -> JointTrajectory:
    """The motion with the path's first time and events, where it has them."""
    states = motion.positions, motion.velocities, motion.accelerations
    if not isinstance(path, JointTrajectory):
        return computed_joints(motion.times, *states, joint_names=names)
    times = path.times[0] + motion.times
    if np.spacing(abs(times[-1])) > _EXACT * np.diff(motion.times).min(initial=np.inf):
        times = motion.times  # times since 1970 would round the steps
    given = np.interp(motion.rows, np.arange(len(path.times)), path.times)
    moved = moved_events(path.events, given, times)
    return computed_joints(times, *states, joint_names=names, events=moved)
