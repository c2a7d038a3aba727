"""Demonstrations of different timing, aligned in time.

Dynamic time warping (Sakoe and Chiba 1978) gives every demonstration the timing of one of them.
Alignment by arc length gives all a constant speed, so that pauses vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    MotionT,
    PoseTrajectory,
    as_demonstration,
    normalised_times,
)

# Samples at which motions are compared; a path of pairs takes a byte for each pair.
_COMPARED = 1000
# Steps shorter than this fraction of the motion's extent are trembling of the hand or noise of the
# sensor: summed over a pause they would count as distance.
_TREMBLING = 2e-3


def align_by_time_warping(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT], *, reference: int | None = None
) -> list[Demonstration[MotionT]]:
    """The demonstrations with the timing of one of them, all at the same 1000 times.

    Positions are compared; orientations and events follow. Velocities and accelerations of joints
    are left out, as they no longer fit.

    Args:
        demonstrations: at least one, all of one type and size, two samples or more each; a motion
            stands for a demonstration of it.
        reference: index of the one whose timing is taken; by default the shortest, as it pauses
            the least.

    Raises:
        InvalidInput: if the demonstrations don't fit, or there is none of that index.
    """
    shown = _comparable(demonstrations)
    durations = [each.motion.duration for each in shown]
    chosen = int(np.argmin(durations))
    if reference is not None:
        chosen = check.integer(reference, "reference", at_least=0, at_most=len(shown) - 1)
    even = np.linspace(0.0, 1.0, _COMPARED)
    compared = [_positions_at(each.motion, even) for each in shown]
    times = np.linspace(0.0, durations[chosen], _COMPARED)
    result = []
    for each, points in zip(shown, compared, strict=True):
        pairs = _core.dtw_path(compared[chosen], points)
        fractions = _mean_partner(pairs) / (_COMPARED - 1.0)
        result.append(Demonstration(_retimed(each.motion, fractions, times), each.name))
    return result


def align_by_arc_length(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT],
) -> list[Demonstration[MotionT]]:
    """The demonstrations at constant speed, all at the same 1000 times.

    All take the median of their durations. Pauses and trembling vanish. Velocities and
    accelerations of joints are left out.

    Args:
        demonstrations: at least one, all of one type and size, two samples or more each; a motion
            stands for a demonstration of it.

    Raises:
        InvalidInput: if the demonstrations don't fit, or one does not move.
    """
    shown = _comparable(demonstrations)
    total = float(np.median([each.motion.duration for each in shown]))
    times = np.linspace(0.0, total, _COMPARED)
    result = []
    for i, each in enumerate(shown):
        at, covered = _distance(each.motion, f"demonstrations[{i}]")
        fractions = np.interp(np.linspace(0.0, covered[-1], _COMPARED), covered, at)
        result.append(Demonstration(_retimed(each.motion, fractions, times), each.name))
    return result


def _comparable(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT],
) -> list[Demonstration[MotionT]]:
    if not isinstance(demonstrations, Sequence):
        got = type(demonstrations).__name__
        raise InvalidInput(
            f"demonstrations: expected a sequence of demonstrations, got one {got}; "
            "put a single one in a list"
        )
    if not demonstrations:
        raise InvalidInput("demonstrations: expected at least one, got none")
    shown = [
        as_demonstration(each, f"demonstrations[{i}]") for i, each in enumerate(demonstrations)
    ]
    for i, each in enumerate(shown):
        if len(each.motion.times) < 2:
            raise InvalidInput(f"demonstrations[{i}]: expected at least two samples, got one")
    if len({(type(each.motion), each.motion.positions.shape[1]) for each in shown}) > 1:
        raise InvalidInput(
            "demonstrations: expected one type of motion and the same number of columns in all"
        )
    return shown


def _positions_at(motion: Motion, fractions: Float64Array) -> Float64Array:
    own = normalised_times(motion.times)
    return np.column_stack([np.interp(fractions, own, column) for column in motion.positions.T])


def _retimed(motion: MotionT, fractions: Float64Array, times: Float64Array) -> MotionT:
    """The motion at fractions (n,) of its duration, which are now at times (n,)."""
    parts: dict[str, Any] = {
        "times": times,
        "positions": _positions_at(motion, fractions),
        "events": events.moved(motion.events, motion.times[0] + fractions * motion.duration, times),
    }
    if isinstance(motion, PoseTrajectory):
        own = normalised_times(motion.times)
        parts["orientations"] = rotations.interpolate(own, motion.orientations, fractions)
    if isinstance(motion, JointTrajectory):
        parts |= {"velocities": None, "accelerations": None}
    return replace(motion, **parts)


def _mean_partner(pairs: NDArray[np.integer[Any]]) -> Float64Array:
    """For each sample of the first curve the mean index of those paired with it, end to end."""
    first, second = pairs[:, 0], pairs[:, 1]
    partners = np.bincount(first, second) / np.bincount(first)
    partners[[0, -1]] = second[[0, -1]]
    return np.asarray(partners)


def _distance(motion: Motion, name: str) -> tuple[Float64Array, Float64Array]:
    """Fractions of the duration, and the distance covered up to each, without trembling."""
    points = motion.positions
    least = _TREMBLING * float(np.linalg.norm(np.ptp(points, axis=0)))
    if least == 0.0:
        raise InvalidInput(f"{name}: does not move; leave it out")
    kept = [0]
    for i in range(1, len(points)):
        if np.linalg.norm(points[i] - points[kept[-1]]) >= least:
            kept.append(i)
    if kept[-1] != len(points) - 1:
        kept[-1 if len(kept) > 1 else 1 :] = [len(points) - 1]
    covered = np.cumsum(np.linalg.norm(np.diff(points[kept], axis=0), axis=1))
    return normalised_times(motion.times)[kept], np.concatenate([[0.0], covered])
