"""One motion from several that follow one another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory

# A motion may begin so far from where the last one ended, m (the unit of the positions) or rad:
# more is no rounding, and the arm would jump.
_GAP = 1e-6


def join(motions: Sequence[Motion]) -> Motion:
    """The motions one after the other, each from where and when the one before ended.

    All of one type and size. The first one's times stay; a sample that ends one and begins the next
    is there once, with the joints' derivatives of the one that ends, which joints keep where all
    have them. Raises InvalidInput, also where one does not begin where the last one ended.
    """
    _check(motions)
    times, happened = [motions[0].times], list(motions[0].events)
    for motion in motions[1:]:
        shift = float(times[-1][-1]) - float(motion.times[0])
        times.append(shift + motion.times[1:])
        last = float(times[-1][-1]) if len(motion.times) > 1 else shift + float(motion.times[0])
        happened += [Event(min(shift + each.time, last), each.name) for each in motion.events]
    clock, positions = np.concatenate(times), _rows(motions, "positions")
    first = motions[0]
    if isinstance(first, PoseTrajectory):
        return PoseTrajectory(clock, positions, _rows(motions, "orientations"), tuple(happened))
    if isinstance(first, Trajectory):
        return Trajectory(clock, positions, tuple(happened))
    velocities, accelerations = (
        None if any(getattr(motion, name) is None for motion in motions) else _rows(motions, name)
        for name in ("velocities", "accelerations")
    )
    names = first.joint_names
    return JointTrajectory(clock, positions, velocities, accelerations, names, tuple(happened))


def _check(motions: Any) -> None:
    if not isinstance(motions, Sequence) or not motions:
        raise InvalidInput("motions: expected a sequence of motions, at least one")
    for motion in motions:
        if not isinstance(motion, Motion):
            raise InvalidInput(f"motions: expected motions, got {type(motion).__name__}")
    kinds = {
        (type(motion), motion.positions.shape[1], getattr(motion, "joint_names", ()))
        for motion in motions
    }
    if len(kinds) > 1:
        raise InvalidInput("motions: expected all of one type and size, with the same joints")
    for i in range(1, len(motions)):
        gap = _gap(motions[i - 1], motions[i])
        if gap > _GAP:
            raise InvalidInput(
                f"motions[{i}]: expected it to begin where the last one ended, got {gap:.3g} away"
            )


def _gap(before: Any, after: Any) -> float:
    away = float(np.linalg.norm(after.positions[0] - before.positions[-1]))
    if isinstance(before, PoseTrajectory):
        turned = rotations.distance(before.orientations[-1:], after.orientations[:1])
        away = max(away, float(turned[0]))
    return away


def _rows(motions: Sequence[Any], name: str) -> Float64Array:
    first, *others = (getattr(motion, name) for motion in motions)
    return np.concatenate([first, *(rows[1:] for rows in others)])
