"""The fastest motion along a path inside velocity, acceleration and jerk limits.

The time-optimal speeds for velocities and accelerations are those of Pham and Pham 2018 in their
interpolation scheme. Averaging them over two windows of time bounds the jerk; where averaging
pushes a joint over a limit, the path is passed a little more slowly, there and nowhere else, and
where passing a narrow turn would take longer, the motion rests there. Straight lines between rests
have a closed form. What is promised is measured on all that leaves: differences of the returned
samples keep the limits, or an error is raised.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, events
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, computed_joints
from leadthrough.timing import request as checks
from leadthrough.timing.bounds import InverseDynamics, Jacobian
from leadthrough.timing.kept import excess, parted, tightened
from leadthrough.timing.lines import time_lines
from leadthrough.timing.paths import path_of
from leadthrough.timing.request import Request
from leadthrough.timing.samples import Samples
from leadthrough.timing.section_law import time_section
from leadthrough.timing.sections import Lines, Sections
from leadthrough.trajectories import Curve

# Short sections lose digits: where that shows, the path is timed again, a little slower.
_MOST_ATTEMPTS = 4


def retime(
    path: JointTrajectory | Curve | ArrayLike,
    limits: JointLimits,
    *,
    rate: float = 1000.0,
    path_tolerance: float = 1e-5,
    blend: float = 0.0,
    holds: Mapping[int, float] | None = None,
    not_before: ArrayLike | None = None,
    start_velocity: ArrayLike | None = None,
    end_velocity: ArrayLike | None = None,
    tip_speed: float | None = None,
    jacobian: Jacobian | None = None,
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
        rate: samples per second.
        path_tolerance: rad (m), how far a fitted path may lie off the samples.
        blend: rad (m), by how much corners between way-points are cut; with 0 the motion rests
            there, as it may where a cut would be so narrow that resting is faster.
        holds: seconds that the motion rests, by row.
        not_before: times (rows,) in seconds, before which no row is reached. With a trajectory's
            own times, its timing is kept wherever the limits allow: the motion is no faster than
            shown, except where it is late by half a percent of its duration or more, and then
            only until it is on time again.
        start_velocity: velocity (joints,) along the path at its start, instead of rest.
        end_velocity: velocity (joints,) along the path at its end, instead of rest; the last step
            may then be shorter or longer than the others by half.
        tip_speed: m/s, that the tip must not exceed; needs `jacobian`.
        jacobian: maps q to (3, joints) or, linear rows first, (6, joints).
        inverse_dynamics: maps q, velocities and accelerations to efforts; with it, the efforts
            keep their limits as well.

    Returns:
        Samples at `rate`, with their central differences as velocities and accelerations. A
        trajectory's events stay at their places on the path.

    Raises:
        InvalidInput: if an argument is malformed or does not fit the path.
        LimitsInfeasible: if a position lies outside its limits, a joint moves whose limit is 0, a
            velocity at an end is too fast, the arm cannot hold itself, or the samples found exceed
            a limit by more than 1e-6 of it.

    Source: Pham and Pham 2018.
    """
    _check_limits(limits)
    way = path_of(path)
    if way.joints != len(limits.joint_names):
        raise InvalidInput(
            f"limits: expected limits of {way.joints} joints, got {len(limits.joint_names)}"
        )
    request = Request(
        rate=check.number(rate, "rate", above=0.0),
        lower=limits.lower,
        upper=limits.upper,
        path_tolerance=check.number(path_tolerance, "path_tolerance", above=0.0),
        blend=check.number(blend, "blend", at_least=0.0),
        holds=checks.checked_holds(holds, way.rows),
        not_before=checks.checked_schedule(not_before, way.rows),
        start_velocity=checks.checked_velocity(start_velocity, "start_velocity", way.joints),
        end_velocity=checks.checked_velocity(end_velocity, "end_velocity", way.joints),
        tip_speed=checks.checked_tip_speed(tip_speed),
        jacobian=jacobian,
        inverse_dynamics=inverse_dynamics,
    )
    motion = _timed(way.sections(request), limits, request, start=way.start)
    return _trajectory(motion, path, limits.joint_names)


def _check_limits(limits: JointLimits) -> None:
    if not isinstance(limits, JointLimits):
        raise InvalidInput(f"limits: expected JointLimits, got {type(limits).__name__}")
    missing = [name for name in ("acceleration", "jerk") if getattr(limits, name) is None]
    if missing:
        raise InvalidInput(
            f"limits: expected {' and '.join(missing)} limits, got none; "
            "`leadthrough info --write-limits` writes a file with assumed ones; in Python, "
            f"Arm.from_urdf takes a file of limits:\n{limits.template()}"
        )


def _timed(
    sections: Sections, limits: JointLimits, request: Request, *, start: Float64Array
) -> Samples:
    """The motion over all sections, with the rests between them; it keeps the limits."""
    ends = request.start_velocity, request.end_velocity
    passes = [velocity is not None and bool(velocity.any()) for velocity in ends]
    inner, found = limits, None
    for _ in range(_MOST_ATTEMPTS):
        motion = parted(_joined(sections, inner, request, start=start), limits, request.rate)
        found = excess(motion, limits, rests=(not passes[0], not passes[1]))
        if found is None:
            return motion
        inner = tightened(inner, found)
    assert found is not None
    raise found.error()


def _joined(
    sections: Sections, limits: JointLimits, request: Request, *, start: Float64Array
) -> Samples:
    """The motions along the sections, one after the other."""
    motions, begin = list[Samples](), sections.initial_hold
    for i, part in enumerate(sections.parts):
        if isinstance(part, Lines):
            motion = time_lines(part, limits, request.rate)
        else:
            own = request.between_rests(first=i == 0, last=i == len(sections.parts) - 1)
            motion = time_section(part, limits, own, begin)
        motions.append(motion)
        begin += float(motion.times[-1])
    moved = Samples.joined(motions) if motions else Samples.at_rest(start)
    return moved.held_before(sections.initial_hold, request.rate)


def _trajectory(
    motion: Samples, path: JointTrajectory | Curve | ArrayLike, names: tuple[str, ...]
) -> JointTrajectory:
    """The motion with the path's first time and events, where it has them."""
    moved = motion.positions, motion.velocities, motion.accelerations
    if not isinstance(path, JointTrajectory):
        return computed_joints(motion.times, *moved, joint_names=names)
    times = path.times[0] + motion.times
    shown = np.interp(motion.places, np.arange(len(path.times)), path.times)
    kept = events.moved(path.events, shown, times)
    return computed_joints(times, *moved, joint_names=names, events=kept)
