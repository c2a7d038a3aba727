"""Bypasses a blocked path segment in joint space; the tip is unconstrained there."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from leadthrough.arm.following import slowed, velocities_of
from leadthrough.arm.ik_failure import with_reason
from leadthrough.arm.limits import JointLimits, known_acceleration
from leadthrough.check import Float64Array, IkFailure
from leadthrough.motion import (
    JointTrajectory,
    PoseTrajectory,
    Trajectory,
    moved_events,
    normalised_times,
    with_derivatives,
)
from leadthrough.motion_planning.connection import connect_configurations
from leadthrough.motion_planning.tip_paths import CollisionFreeIk, TipMotion, blocked_segment_at
from leadthrough.preprocess import join
from leadthrough.trajectories import minimum_jerk_time_scaling

# Peak speed and acceleration of a minimum-jerk motion by 1 in 1 s.
_PEAK_SPEED, _PEAK_ACCELERATION = 1.875, 5.7736
# Steps of a connection's trees before more of the path is given up.
_STEPS = 60_000
# Fraction of the limits that the motion uses.
_PACE = 0.5


def bypass(
    ik: CollisionFreeIk, path: TipMotion, failure: IkFailure, following: dict[str, Any]
) -> tuple[JointTrajectory, TipMotion, tuple[float, float]]:
    """A motion along a path with a part in joint space, from rest to rest."""
    segment = blocked_segment_at(ik, path, failure.index, failure.q)
    if segment.end:
        raise with_reason(failure, f"no collision-free configuration found at the {segment.end}")
    last, more = len(segment.tested) - 1, 1
    while True:
        first, end = max(0, segment.first - more), min(last, segment.last + more)
        pieces = _beside(ik, path, following, segment.tested[first], segment.tested[end])
        part = pieces and _part(ik, path, *pieces)
        if pieces and part:
            before, after = pieces
            part = _with_events(part, path, len(before) - 1, -len(after))
            joints = _in_limits(ik, join([before, part, after]))
            ends = path[: len(before)], path[len(path) - len(after) :]
            tip = join([ends[0], _tip_of(ik, ends, part), ends[1]])
            begin, stop = joints.times[[len(before) - 1, -len(after)]]
            return joints, tip, (float(begin), float(stop))
        if first == 0 and end == last:
            raise with_reason(failure, "no connection in joint space was found")
        more *= 2


def _beside(
    ik: CollisionFreeIk, path: TipMotion, following: dict[str, Any], first: int, last: int
) -> tuple[JointTrajectory, JointTrajectory] | None:
    """The joints up to a sample and from another one on; None if the arm cannot follow."""
    pieces: list[JointTrajectory] = []
    for rows in (slice(0, first + 1), slice(last, None)):
        options = following["options"]
        cut = replace(options, posture=_cut(options.posture, path, rows))
        how = following | {"options": cut}
        if pieces:
            how["q0"] = pieces[0].positions[-1]
        try:
            pieces.append(ik.arm.follow(path[rows], **how))
        except IkFailure:
            return None
    return pieces[0], pieces[1]


def _cut(posture: Any, path: TipMotion, rows: slice) -> Any:
    if not isinstance(posture, JointTrajectory):
        return posture
    at = posture.times[0] + normalised_times(path.times)[rows] * posture.duration
    return JointTrajectory(path.times[rows], posture.at(at), joint_names=posture.joint_names)


def _part(
    ik: CollisionFreeIk, path: TipMotion, before: JointTrajectory, after: JointTrajectory
) -> JointTrajectory | None:
    """From the end of one motion to the start of another; None if no way was found."""
    way = connect_configurations(
        ik.single,
        before.positions[-1],
        after.positions[0],
        ik.scene.for_planning(),
        steps=_STEPS,
    )
    if way is None:
        return None
    dt = float(np.median(np.diff(path.times)))
    times, q = _from_rest_to_rest(way, ik.arm.limits, dt)
    return JointTrajectory(times, q, joint_names=tuple(ik.arm.joint_names))


def _from_rest_to_rest(
    way: Float64Array, limits: JointLimits, dt: float
) -> tuple[Float64Array, Float64Array]:
    """Times (n,) and configurations (n, joints) on straight ways, with a stop at each corner."""
    times, rows = [np.zeros(1)], [way[:1]]
    for here, there in pairwise(way):
        step = np.abs(there - here)
        needed = np.maximum(
            _PEAK_SPEED * step / (_PACE * limits.velocity),
            np.sqrt(_PEAK_ACCELERATION * step / (_PACE * known_acceleration(limits))),
        )
        duration = max(float(needed.max()), dt)
        share = np.linspace(0.0, 1.0, int(np.ceil(duration / dt)) + 1)[1:]
        times.append(times[-1][-1] + duration * share)
        rows.append(here + minimum_jerk_time_scaling(share)[:, None] * (there - here))
    return np.concatenate(times), np.vstack(rows)


def _with_events(part: JointTrajectory, path: TipMotion, first: int, last: int) -> JointTrajectory:
    ends = path.times[[first, last]]
    between = tuple(each for each in path.events if ends[0] < each.time < ends[1])
    return replace(part, events=moved_events(between, ends, part.times[[0, -1]]))


def _in_limits(ik: CollisionFreeIk, joints: JointTrajectory) -> JointTrajectory:
    """The motion, slower where its parts meet."""
    q = joints.positions
    times = slowed(joints.times, q, ik.arm.limits)
    velocities = velocities_of(times, q)
    velocities[[0, -1]] = 0.0
    moved = moved_events(joints.events, joints.times, times)
    return with_derivatives(
        replace(joints, times=times, velocities=velocities, accelerations=None, events=moved)
    )


def _tip_of(
    ik: CollisionFreeIk, ends: tuple[TipMotion, TipMotion], part: JointTrajectory
) -> TipMotion:
    """The motion of the tip along a part, from the end of one path to the start of another."""
    poses = ik.arm.poses(part)
    positions, orientations = poses.positions.copy(), poses.orientations.copy()
    positions[[0, -1]] = ends[0].positions[-1], ends[1].positions[0]
    if not isinstance(ends[0], PoseTrajectory) or not isinstance(ends[1], PoseTrajectory):
        return Trajectory(poses.times, positions, part.events)
    orientations[[0, -1]] = ends[0].orientations[-1], ends[1].orientations[0]
    return PoseTrajectory(poses.times, positions, orientations, part.events)
