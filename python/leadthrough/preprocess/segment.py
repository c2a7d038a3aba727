"""Cuts recordings into motions at the pauses between them, and joins consecutive motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import (
    Demonstration,
    Event,
    Motion,
    MotionT,
    PoseTrajectory,
    alike,
    as_demonstration,
    checked_motion,
    fields_of,
    rows_of,
)
from leadthrough.rest import HYSTERESIS, runs, speeds_of, thresholds_of

# m (or the unit of the positions) or rad between the end of a motion and the start of the next:
# rounding stays below, and with more the arm would jump.
_GAP = 1e-6


def segment(
    demonstration: Demonstration[MotionT] | MotionT,
    *,
    speed: float | None = None,
    angular_speed: float | None = None,
    pause: float = 0.3,
    shortest: float = 0.5,
) -> list[Demonstration[MotionT]]:
    """The motions in a recording, in order; an empty list where nothing moves.

    A motion starts where one of the speeds exceeds its threshold, and ends where both stay below
    half of theirs for a pause. Speeds are slopes over the length of a pause, so that noise and
    single outliers neither start nor end a motion. Each motion keeps its recorded times,
    its events and half a pause before and after, and is named after the recording and its number.

    Args:
        demonstration: the recording; a motion stands for a demonstration of it.
        speed: threshold, > 0, m/s, or the unit of the positions per second; of joints the norm over
            all of them, rad/s. By default it follows from the recording, as for `trim`.
        angular_speed: threshold of poses, > 0, rad/s; by default as for `speed`.
        pause: s, > 0.
        shortest: s, > 0; shorter motions are left out.
    """
    demonstration = as_demonstration(demonstration, "demonstration")
    window = check.number(pause, "pause", above=0.0)
    least = check.number(shortest, "shortest", above=0.0)
    motion = demonstration.motion
    speeds = speeds_of(motion, window)
    moving = speeds.in_multiples_of(thresholds_of(speeds, speed, angular_speed))
    pieces = [
        piece
        for piece in _pieces(motion.times, moving, window)
        if motion.times[piece.stop - 1] - motion.times[piece.start] >= least
    ]
    return [
        Demonstration(cast(MotionT, motion[piece]), name=f"{demonstration.name} {number}".strip())
        for number, piece in enumerate(pieces, start=1)
    ]


def _pieces(times: Float64Array, moving: Float64Array, pause: float) -> list[slice]:
    """The samples of each motion, with half a pause before and after."""
    found: list[list[int]] = []
    for start, stop in runs(moving >= HYSTERESIS):
        if found and times[start] - times[found[-1][1] - 1] < pause:
            found[-1][1] = stop
        else:
            found.append([start, stop])
    return [
        slice(
            int(np.searchsorted(times, times[start] - 0.5 * pause)),
            int(np.searchsorted(times, times[stop - 1] + 0.5 * pause, side="right")),
        )
        for start, stop in found
        if (moving[start:stop] >= 1.0).any()
    ]


def join(motions: Sequence[MotionT]) -> MotionT:
    """One motion of several, each starting where and when the one before ended.

    The first motion keeps its times. Of two samples that meet, the first stays. Velocities
    and accelerations of joints are kept if all motions have them.

    Args:
        motions: at least one, all of one type and size, joints with the same names in any order;
            the first one's order counts.

    Raises:
        InvalidInput: if they differ in type, size or joints, or one does not start where the one
            before ended.
    """
    motions = _checked(motions)
    times, joined_events = [motions[0].times], list(motions[0].events)
    for motion in motions[1:]:
        shift = float(times[-1][-1]) - float(motion.times[0])
        times.append(shift + motion.times[1:])
        last = float(times[-1][-1]) if len(motion.times) > 1 else shift + float(motion.times[0])
        joined_events += [Event(min(shift + each.time, last), each.name) for each in motion.events]
    every = [rows_of(motion) for motion in motions]
    joined: dict[str, Any] = {
        name: np.concatenate([every[0][name], *(rows[name][1:] for rows in every[1:])])
        if all(name in rows for rows in every)
        else None
        for name in every[0]
    }
    rows = fields_of(motions[0], joined)
    return replace(motions[0], times=np.concatenate(times), events=tuple(joined_events), **rows)


def _checked(motions: Sequence[MotionT]) -> list[MotionT]:
    if not isinstance(motions, Sequence) or not motions:
        raise InvalidInput("motions: expected a sequence of at least one motion")
    for i, motion in enumerate(motions):
        checked_motion(motion, f"motions[{i}]")
    if len({(type(motion), motion.positions.shape[1]) for motion in motions}) > 1:
        raise InvalidInput("motions: expected all of one type and size")
    ordered = alike(motions, "motions")
    for i in range(1, len(motions)):
        gap = _gap(ordered[i - 1], ordered[i])
        if gap > _GAP:
            raise InvalidInput(
                f"motions[{i}]: expected it to start where motions[{i - 1}] ended, got a start "
                f"{gap:.3g} away"
            )
    return ordered


def _gap(before: Motion, after: Motion) -> float:
    away = float(np.linalg.norm(after.positions[0] - before.positions[-1]))
    if isinstance(before, PoseTrajectory) and isinstance(after, PoseTrajectory):
        angle = rotations.distance(before.orientations[-1:], after.orientations[:1])
        away = max(away, float(angle[0]))
    return away
