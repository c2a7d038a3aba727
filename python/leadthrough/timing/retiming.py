"""The fastest motion along a path inside velocity, acceleration and jerk limits.

The time-optimal speeds for velocities and accelerations are those of Pham and Pham 2018 in their
interpolation scheme. Averaged over two windows of time they have a bounded jerk; where averaging
pushes a joint over a limit, the path is passed a little more slowly, there and nowhere else. What
is promised is measured: differences of the samples given back keep the limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from leadthrough import check, events
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory
from leadthrough.timing.bounds import InverseDynamics, Jacobian
from leadthrough.timing.request import Request
from leadthrough.timing.samples import Motion
from leadthrough.timing.section_law import time_section
from leadthrough.timing.sections import Section, sections
from leadthrough.trajectories import Curve


def retime(
    path: Any,
    limits: JointLimits,
    *,
    rate: float = 1000.0,
    path_tolerance: float = 1e-5,
    blend: float = 0.0,
    holds: Mapping[int, float] | None = None,
    not_before: Any = None,
    start_velocity: Any = None,
    end_velocity: Any = None,
    tip_speed: float | None = None,
    jacobian: Jacobian | None = None,
    inverse_dynamics: InverseDynamics | None = None,
) -> JointTrajectory:
    """The fastest motion along a path inside the limits, from rest to rest, sampled evenly.

    path: a JointTrajectory, through whose samples a smooth path is fitted; a curve of
        `leadthrough.trajectories`, of which a Spline with two continuous derivatives is followed
        exactly and one with corners rests at them; or way-points (n, joints), joined by straight
        lines.
    rate: samples a second. path_tolerance: rad (m), how far a fitted path may lie off the samples.
    blend: rad (m), by how much corners between way-points are cut; with 0 the motion rests there.
    holds: s by row (way-point, sample or knot), how long the motion rests there.
    not_before: (n,) s by row; no row is reached before its time. With a trajectory's own times, its
        timing is kept wherever the limits allow: the motion is no faster than shown but where it is
        late, by half a percent of its duration or more, and then until it is on time again.
    start_velocity, end_velocity: (joints,) along the path, where it is not to begin or end at rest;
        the last step may then be shorter or longer than the others by half.
    tip_speed: m/s, of the tip, whose `jacobian` maps q to (3, joints) or, linear rows first,
        (6, joints). inverse_dynamics: maps q, velocities and accelerations to efforts, which then
        keep their limits as well.
    Velocities and accelerations given back are the samples' central differences; a trajectory's
    events stay at their places on the path.
    Raises InvalidInput; LimitsInfeasible where a position lies outside its limits, a joint moves
    that must not, a velocity at an end is too fast, or an arm cannot hold itself.
    """
    _check_limits(limits)
    rows, joints = _shape(path)
    if joints != len(limits.joint_names):
        raise InvalidInput(
            f"limits: expected limits of {joints} joints, got {len(limits.joint_names)}"
        )
    request = Request(
        rows=rows,
        joints=joints,
        rate=rate,
        path_tolerance=path_tolerance,
        blend=blend,
        holds={} if holds is None else holds,
        not_before=not_before,
        start_velocity=start_velocity,
        end_velocity=end_velocity,
        tip_speed=tip_speed,
        jacobian=jacobian,
        inverse_dynamics=inverse_dynamics,
    )
    rest, parts = sections(
        path, path_tolerance=request.path_tolerance, blend=request.blend, holds=request.holds
    )
    motions = _motions(parts, limits, request, begin=rest) or [_standing(path)]
    motions[0] = motions[0].held_before(rest, request.rate)
    return _joined(motions, path, limits.joint_names)


def _motions(
    parts: list[Section], limits: JointLimits, request: Request, *, begin: float
) -> list[Motion]:
    motions, last = list[Motion](), len(parts) - 1
    for i, part in enumerate(parts):
        motion = time_section(part, limits, request, begin=begin, first=i == 0, last=i == last)
        begin += float(motion.times[-1])
        motions.append(motion)
    return motions


def _shape(path: Any) -> tuple[int, int]:
    """Rows and joints of a path of any kind."""
    if isinstance(path, JointTrajectory):
        return path.positions.shape
    if isinstance(path, Curve):
        return len(path.knots), path.evaluate(path.domain[0]).shape[0]
    points = check.array(path, "path", shape=("n", "joints"))
    if 0 in points.shape:
        raise InvalidInput(f"path: expected way-points (n, joints), got shape {points.shape}")
    return points.shape


def _check_limits(limits: Any) -> None:
    if not isinstance(limits, JointLimits):
        raise InvalidInput(f"limits: expected JointLimits, got {type(limits).__name__}")
    for name in ("acceleration", "jerk"):
        if getattr(limits, name) is None:
            raise InvalidInput(
                f"limits: expected {name} limits, got none; a file that states them:\n"
                f"{limits.template()}"
            )


def _standing(path: Any) -> Motion:
    if isinstance(path, JointTrajectory):
        q = path.positions[:1]
    elif isinstance(path, Curve):
        q = path.evaluate([path.domain[0]])
    else:
        q = np.asarray(path, dtype=np.float64)[:1]
    return Motion(np.zeros(1), np.zeros(1), q, np.zeros_like(q), np.zeros_like(q))


def _joined(motions: list[Motion], path: Any, names: tuple[str, ...]) -> JointTrajectory:
    whole = motions[0]
    for motion in motions[1:]:
        whole = whole.followed_by(motion)
    timed = whole.positions, whole.velocities, whole.accelerations
    if not isinstance(path, JointTrajectory):
        return JointTrajectory(whole.times, *timed, names)
    times = path.times[0] + whole.times
    shown = np.interp(whole.places, np.arange(len(path.times)), path.times)
    return JointTrajectory(times, *timed, names, events.moved(path.events, shown, times))
