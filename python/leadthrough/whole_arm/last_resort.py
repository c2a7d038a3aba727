"""Past a part of a path without room through joint space, where the tip goes as it has to."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from leadthrough import events
from leadthrough.arm.following import slowed, velocities_of
from leadthrough.arm.limits import JointLimits, known_acceleration
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory, normalised_times
from leadthrough.preprocess import join
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough.whole_arm.connection import way_between
from leadthrough.whole_arm.room import Room, narrows_at
from leadthrough.whole_arm.tip_paths import TipMotion, with_reason

# The greatest speed and acceleration of a minimum-jerk motion by 1 in 1 s.
_FASTEST, _STRONGEST = 1.875, 5.7736
# That the trees of a connection may grow before more of the path is given up.
_STEPS = 60_000
# Fraction of the limits that the arm moves at.
_PACE = 0.5


def past_the_part(
    room: Room, path: TipMotion, failure: IkFailure, following: dict[str, Any]
) -> tuple[JointTrajectory, TipMotion, tuple[float, float]]:
    """A motion along a path with a part in joint space, from standstill to standstill."""
    narrows = narrows_at(room, path, failure.index, failure.q)
    if narrows.end:
        raise with_reason(failure, f"the arm cannot stand clear at the {narrows.end}")
    last, more = len(narrows.places) - 1, 1
    while True:
        first, end = max(0, narrows.first - more), min(last, narrows.last + more)
        pieces = _beside(room, path, following, narrows.places[first], narrows.places[end])
        part = pieces and _part(room, path, *pieces)
        if pieces and part:
            before, after = pieces
            part = _with_events(part, path, len(before) - 1, -len(after))
            joints = _in_limits(room, join([before, part, after]))
            ends = path[: len(before)], path[len(path) - len(after) :]
            tip = join([ends[0], _tip_of(room, ends, part), ends[1]])
            begin, stop = joints.times[[len(before) - 1, -len(after)]]
            return joints, tip, (float(begin), float(stop))
        if first == 0 and end == last:
            raise with_reason(failure, "no connection in joint space was found")
        more *= 2


def _beside(
    room: Room, path: TipMotion, following: dict[str, Any], first: int, last: int
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
            pieces.append(room.arm.follow(path[rows], **how))
        except IkFailure:
            return None
    return pieces[0], pieces[1]


def _cut(posture: Any, path: TipMotion, rows: slice) -> Any:
    """The preferred posture for some samples of a path."""
    if not isinstance(posture, JointTrajectory):
        return posture
    at = posture.times[0] + normalised_times(path.times)[rows] * posture.duration
    return JointTrajectory(path.times[rows], posture.at(at), joint_names=posture.joint_names)


def _part(
    room: Room, path: TipMotion, before: JointTrajectory, after: JointTrajectory
) -> JointTrajectory | None:
    """From the end of one motion to the start of another; None if no way was found."""
    way = way_between(
        room.arm,
        before.positions[-1],
        after.positions[0],
        room.scene.for_planning(),
        steps=_STEPS,
    )
    if way is None:
        return None
    dt = float(np.median(np.diff(path.times)))
    times, q = _from_rest_to_rest(way, room.arm.limits, dt)
    return JointTrajectory(times, q, joint_names=tuple(room.arm.joint_names))


def _from_rest_to_rest(
    way: Float64Array, limits: JointLimits, dt: float
) -> tuple[Float64Array, Float64Array]:
    """Times (n,) and configurations (n, joints) on straight ways, with a stop at each corner."""
    times, rows = [np.zeros(1)], [way[:1]]
    for here, there in pairwise(way):
        step = np.abs(there - here)
        needed = np.maximum(
            _FASTEST * step / (_PACE * limits.velocity),
            np.sqrt(_STRONGEST * step / (_PACE * known_acceleration(limits))),
        )
        duration = max(float(needed.max()), dt)
        share = np.linspace(0.0, 1.0, int(np.ceil(duration / dt)) + 1)[1:]
        times.append(times[-1][-1] + duration * share)
        rows.append(here + minimum_jerk_time_scaling(share)[:, None] * (there - here))
    return np.concatenate(times), np.vstack(rows)


def _with_events(part: JointTrajectory, path: TipMotion, first: int, last: int) -> JointTrajectory:
    """With the events between two samples of the path."""
    ends = path.times[[first, last]]
    between = tuple(each for each in path.events if ends[0] < each.time < ends[1])
    return replace(part, events=events.moved(between, ends, part.times[[0, -1]]))


def _in_limits(room: Room, joints: JointTrajectory) -> JointTrajectory:
    """The motion, slower where its parts meet."""
    q = joints.positions
    times = slowed(room.arm._chain, joints.times, q, room.arm.limits)
    velocities = velocities_of(times, q)
    velocities[[0, -1]] = 0.0
    moved = events.moved(joints.events, joints.times, times)
    return replace(joints, times=times, velocities=velocities, events=moved)


def _tip_of(room: Room, ends: tuple[TipMotion, TipMotion], part: JointTrajectory) -> TipMotion:
    """The motion of the tip along a part, from the end of one path to the start of another."""
    poses = room.arm.poses(part)
    positions, orientations = poses.positions.copy(), poses.orientations.copy()
    positions[[0, -1]] = ends[0].positions[-1], ends[1].positions[0]
    if not isinstance(ends[0], PoseTrajectory) or not isinstance(ends[1], PoseTrajectory):
        return Trajectory(poses.times, positions, part.events)
    orientations[[0, -1]] = ends[0].orientations[-1], ends[1].orientations[0]
    return PoseTrajectory(poses.times, positions, orientations, part.events)
