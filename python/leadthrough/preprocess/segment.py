"""Cuts long recordings into motions at the pauses between them."""

from __future__ import annotations

import numpy as np

from leadthrough import check, events
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
)
from leadthrough.preprocess.activity import HYSTERESIS, activity, runs


def segment(
    demonstration: Demonstration,
    *,
    speed: float = 0.01,
    angular_speed: float = 0.05,
    pause: float = 0.3,
    shortest: float = 0.5,
) -> list[Demonstration]:
    """The motions of a recording, in order; none where nothing moves.

    A motion begins where the speed exceeds `speed` (m/s, or the unit of the positions a second; of
    joints the norm over all, rad/s) or `angular_speed` (rad/s, poses only), and ends where both
    stay below half of them for `pause` s. Speeds are means over `pause`, so that noise and single
    outliers neither begin nor end a motion. Motions shorter than `shortest` s are left out. Each
    keeps its recorded times, half a pause before and after and the events meanwhile, and is named
    after the recording and its number. All arguments > 0. Raises InvalidInput.
    """
    if not isinstance(demonstration, Demonstration):
        got = type(demonstration).__name__
        raise InvalidInput(f"demonstration: expected a Demonstration, got {got}")
    check.number(speed, "speed", above=0.0)
    check.number(angular_speed, "angular_speed", above=0.0)
    window = check.number(pause, "pause", above=0.0)
    least = check.number(shortest, "shortest", above=0.0)
    motion = demonstration.motion
    moving = activity(motion, speed=speed, angular_speed=angular_speed, window=window)
    pieces = [
        piece
        for piece in _pieces(motion.times, moving, window)
        if motion.times[piece.stop - 1] - motion.times[piece.start] >= least
    ]
    return [
        Demonstration(_cut(motion, piece), name=f"{demonstration.name} {number}".strip())
        for number, piece in enumerate(pieces, start=1)
    ]


def _pieces(times: Float64Array, moving: Float64Array, pause: float) -> list[slice]:
    """Runs of samples that move, with half a pause around them, where one moves enough."""
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


def _cut(motion: Motion, piece: slice) -> Motion:
    times, positions = motion.times[piece], motion.positions[piece]
    happened = events.within(motion.events, times[0], times[-1])
    if isinstance(motion, PoseTrajectory):
        return PoseTrajectory(times, positions, motion.orientations[piece], happened)
    if isinstance(motion, Trajectory):
        return Trajectory(times, positions, happened)
    velocities, accelerations = (
        None if values is None else values[piece]
        for values in (motion.velocities, motion.accelerations)
    )
    names = motion.joint_names
    return JointTrajectory(times, positions, velocities, accelerations, names, happened)
