"""One motion from several consecutive ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event
from leadthrough.motion import Motion, MotionT, PoseTrajectory, checked_motion, fields_of, rows_of

# m (or the unit of the positions) or rad between the end of a motion and the start of the next:
# rounding stays below, and with more the arm would jump.
_GAP = 1e-6


def join(motions: Sequence[MotionT]) -> MotionT:
    """One motion of several, each starting where and when the one before ended.

    The first motion keeps its times. Where two meet, the last sample of the first stays. Velocities
    and accelerations of joints are kept if all motions have them.

    Args:
        motions: at least one, all of one type and size, joints with the same names.

    Raises:
        InvalidInput: if they differ in type, size or joints, or one does not start where the one
            before ended.
    """
    _check(motions)
    times, joined_events = [motions[0].times], list(motions[0].events)
    for motion in motions[1:]:
        shift = float(times[-1][-1]) - float(motion.times[0])
        times.append(shift + motion.times[1:])
        last = float(times[-1][-1]) if len(motion.times) > 1 else shift + float(motion.times[0])
        joined_events += [Event(min(shift + each.time, last), each.name) for each in motion.events]
    every = [rows_of(motion) for motion in motions]
    joined: dict[str, Any] = {
        name: _joined([rows[name] for rows in every])
        if all(name in rows for rows in every)
        else None
        for name in every[0]
    }
    rows = fields_of(motions[0], joined)
    return replace(motions[0], times=np.concatenate(times), events=tuple(joined_events), **rows)


def _check(motions: Sequence[Motion]) -> None:
    if not isinstance(motions, Sequence) or not motions:
        raise InvalidInput("motions: expected a sequence of at least one motion")
    for i, motion in enumerate(motions):
        checked_motion(motion, f"motions[{i}]")
    kinds = {
        (type(motion), motion.positions.shape[1], getattr(motion, "joint_names", ()))
        for motion in motions
    }
    if len(kinds) > 1:
        raise InvalidInput("motions: expected all of one type and size, with the same joint names")
    for i in range(1, len(motions)):
        gap = _gap(motions[i - 1], motions[i])
        if gap > _GAP:
            raise InvalidInput(
                f"motions[{i}]: expected it to start where motions[{i - 1}] ended, got a start "
                f"{gap:.3g} away"
            )


def _gap(before: Motion, after: Motion) -> float:
    away = float(np.linalg.norm(after.positions[0] - before.positions[-1]))
    if isinstance(before, PoseTrajectory) and isinstance(after, PoseTrajectory):
        turned = rotations.distance(before.orientations[-1:], after.orientations[:1])
        away = max(away, float(turned[0]))
    return away


def _joined(rows: Sequence[Float64Array]) -> Float64Array:
    first, *others = rows
    return np.concatenate([first, *(each[1:] for each in others)])
