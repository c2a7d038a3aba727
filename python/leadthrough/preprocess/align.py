"""Demonstrations of different timing, aligned in time.

Time warping brings every demonstration to the mean timing of all (`warps`). Alignment by arc length
gives all a constant speed, so that pauses vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import check, events, rotations
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
from leadthrough.preprocess.in_step import FREE, fractions_in_step
from leadthrough.preprocess.warps import COMPARED, features, positions_at, warp

# Steps shorter than this fraction of the motion's extent are trembling of the hand or noise of the
# sensor: summed over a pause they would count as distance.
_TREMBLING = 2e-3


def align_by_time_warping(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT], *, reference: int | None = None
) -> list[Demonstration[MotionT]]:
    """The demonstrations with their mean timing, all at the same times, mostly 1000.

    What happens at some fraction of the duration happens in the demonstrations at that fraction
    on average. Positions and orientations are compared, each in units of its extent; events
    follow. Velocities and accelerations of joints are left out, as they no longer fit.

    Differences in timing stay where taking them away gains nothing beyond chance: where warping
    leaves more than half of the spread, and the mean of the others predicts a left-out
    demonstration no better after it. Demonstrations that also share their times come back as they
    are.

    Args:
        demonstrations: at least one, all of one type and size, two samples or more each; a motion
            stands for a demonstration of it.
        reference: index of one whose timing and duration all others take, instead of the mean's.

    Raises:
        InvalidInput: if the demonstrations don't fit, or there is none of that index.
    """
    shown = _comparable(demonstrations)
    motions = [each.motion for each in shown]
    durations = [motion.duration for motion in motions]
    if reference is None:
        total, warps = float(np.mean(durations)), fractions_in_step(motions)
        if warps is None:
            if all(np.array_equal(each.times, motions[0].times) for each in motions):
                return shown
            warps = [np.linspace(0.0, 1.0, COMPARED)] * len(shown)
    else:
        chosen = check.integer(reference, "reference", at_least=0, at_most=len(shown) - 1)
        total, curves = durations[chosen], features(motions)
        warps = [warp(curves[chosen], each, rigidity=FREE) for each in curves]
    times = np.linspace(0.0, total, COMPARED)
    return [
        Demonstration(_retimed(each.motion, fractions, times), each.name)
        for each, fractions in zip(shown, warps, strict=True)
    ]


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
    times = np.linspace(0.0, total, COMPARED)
    result = []
    for i, each in enumerate(shown):
        at, covered = _distance(each.motion, f"demonstrations[{i}]")
        fractions = np.interp(np.linspace(0.0, covered[-1], COMPARED), covered, at)
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


def _retimed(motion: MotionT, fractions: Float64Array, times: Float64Array) -> MotionT:
    """The motion at fractions (n,) of its duration, which are now at times (n,)."""
    parts: dict[str, Any] = {
        "times": times,
        "positions": positions_at(motion, fractions),
        "events": events.moved(motion.events, motion.times[0] + fractions * motion.duration, times),
    }
    if isinstance(motion, PoseTrajectory):
        own = normalised_times(motion.times)
        parts["orientations"] = rotations.interpolate(own, motion.orientations, fractions)
    if isinstance(motion, JointTrajectory):
        parts |= {"velocities": None, "accelerations": None}
    elif (joints := motion.joints) is not None:
        rows = positions_at(joints, fractions)
        parts["joints"] = JointTrajectory(times, rows, joint_names=joints.joint_names)
    return replace(motion, **parts)


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
