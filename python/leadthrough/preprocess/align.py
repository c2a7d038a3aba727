"""Demonstrations that take their time differently, brought onto one clock.

By dynamic time warping (Sakoe and Chiba 1978) every demonstration follows the timing of one of
them; by arc length all go at one speed, and pauses vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough import _core, check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    normalised_times,
)

# Samples at which motions are compared; a path of pairs takes a byte for each pair.
_COMPARED = 1000
# Steps shorter than this share of the motion's extent are the hand's or the sensor's trembling:
# summed over a pause they would count as a way.
_TREMBLING = 2e-3


def align_by_time_warping(
    demonstrations: Sequence[Demonstration], *, reference: int | None = None
) -> list[Demonstration]:
    """The demonstrations in the timing of one of them, all at the same 1000 times.

    reference: its index; by default the one that takes the least time, as it pauses the least.
    Positions are compared; orientations go along. Velocities and
    accelerations of joints are left out, as they no longer fit. Raises InvalidInput.
    """
    motions = _motions(demonstrations)
    durations = [motion.duration for motion in motions]
    chosen = int(np.argmin(durations))
    if reference is not None:
        chosen = check.integer(reference, "reference", at_least=0, at_most=len(motions) - 1)
    even = np.linspace(0.0, 1.0, _COMPARED)
    compared = [_positions_at(motion, even) for motion in motions]
    clock = np.linspace(0.0, durations[chosen], _COMPARED)
    result = []
    for demonstration, motion, points in zip(demonstrations, motions, compared, strict=True):
        pairs = _core.dtw_path(compared[chosen], points)
        shares = _mean_partner(pairs) / (_COMPARED - 1.0)
        result.append(Demonstration(_taken_at(motion, shares, clock), demonstration.name))
    return result


def align_by_arc_length(demonstrations: Sequence[Demonstration]) -> list[Demonstration]:
    """The demonstrations at constant speed, all at the same 1000 times.

    They take as long as they did in the median. Pauses and trembling vanish. Velocities and
    accelerations of joints are left out. Raises InvalidInput, also for one that does not move.
    """
    motions = _motions(demonstrations)
    total = float(np.median([motion.duration for motion in motions]))
    clock = np.linspace(0.0, total, _COMPARED)
    result = []
    for i, (demonstration, motion) in enumerate(zip(demonstrations, motions, strict=True)):
        at, covered = _way(motion, f"demonstrations[{i}]")
        shares = np.interp(np.linspace(0.0, covered[-1], _COMPARED), covered, at)
        result.append(Demonstration(_taken_at(motion, shares, clock), demonstration.name))
    return result


def _motions(demonstrations: Sequence[Demonstration]) -> list[Motion]:
    if isinstance(demonstrations, Demonstration) or not isinstance(demonstrations, Sequence):
        got = type(demonstrations).__name__
        raise InvalidInput(f"demonstrations: expected a sequence of them, got {got}")
    if not demonstrations:
        raise InvalidInput("demonstrations: expected at least one")
    motions: list[Any] = [getattr(each, "motion", None) for each in demonstrations]
    for i, motion in enumerate(motions):
        if not isinstance(motion, Motion) or len(motion.times) < 2:
            raise InvalidInput(f"demonstrations[{i}]: expected one of two samples or more")
    if len({(type(motion), motion.positions.shape[1]) for motion in motions}) > 1:
        raise InvalidInput("demonstrations: expected all of one type and size")
    return motions


def _positions_at(motion: Motion, shares: Float64Array) -> Float64Array:
    own = normalised_times(motion.times)
    return np.column_stack([np.interp(shares, own, column) for column in motion.positions.T])


def _taken_at(motion: Motion, shares: Float64Array, clock: Float64Array) -> Motion:
    """The motion as it was at shares (n,) of its time, at the times of a clock (n,)."""
    positions = _positions_at(motion, shares)
    happening = events.moved(motion.events, motion.times[0] + shares * motion.duration, clock)
    if isinstance(motion, PoseTrajectory):
        turned = rotations.interpolate(normalised_times(motion.times), motion.orientations, shares)
        return PoseTrajectory(clock, positions, turned, happening)
    if isinstance(motion, JointTrajectory):
        names = motion.joint_names
        return JointTrajectory(clock, positions, joint_names=names, events=happening)
    return Trajectory(clock, positions, happening)


def _mean_partner(pairs: Any) -> Float64Array:
    """For each sample of the first curve the mean of those paired with it; rising, end to end."""
    first, second = pairs[:, 0], pairs[:, 1]
    partners = np.bincount(first, second) / np.bincount(first)
    partners[[0, -1]] = second[[0, -1]]
    return np.asarray(partners)


def _way(motion: Motion, name: str) -> tuple[Float64Array, Float64Array]:
    """Shares of the time, and the way covered up to them, without trembling."""
    points = motion.positions
    least = _TREMBLING * float(np.linalg.norm(np.ptp(points, axis=0)))
    if least == 0.0:
        raise InvalidInput(f"{name}: expected a motion, it does not move")
    kept = [0]
    for i in range(1, len(points)):
        if np.linalg.norm(points[i] - points[kept[-1]]) >= least:
            kept.append(i)
    if kept[-1] != len(points) - 1:
        kept[-1 if len(kept) > 1 else 1 :] = [len(points) - 1]
    covered = np.cumsum(np.linalg.norm(np.diff(points[kept], axis=0), axis=1))
    return normalised_times(motion.times)[kept], np.concatenate([[0.0], covered])
