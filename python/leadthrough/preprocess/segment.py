"""Cuts long recordings into motions at the pauses between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
)

# A motion that goes on may be slower than one that begins, by this factor.
_HYSTERESIS = 0.5


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
    activity = _speeds(motion, window) / speed
    if isinstance(motion, PoseTrajectory):
        activity = np.maximum(activity, _angular_speeds(motion, window) / angular_speed)
    pieces = [
        piece
        for piece in _pieces(motion.times, activity, window)
        if motion.times[piece.stop - 1] - motion.times[piece.start] >= least
    ]
    return [
        Demonstration(_cut(motion, piece), name=f"{demonstration.name} {number}".strip())
        for number, piece in enumerate(pieces, start=1)
    ]


def _around(times: Float64Array, window: float) -> tuple[Float64Array, Float64Array]:
    """The ends of the window about each time, inside the recording."""
    return (
        np.maximum(times - 0.5 * window, times[0]),
        np.minimum(times + 0.5 * window, times[-1]),
    )


def _speeds(motion: Motion, window: float) -> Float64Array:
    before, after = _around(motion.times, window)
    steps = [
        np.interp(after, motion.times, column) - np.interp(before, motion.times, column)
        for column in motion.positions.T
    ]
    return _per_second(np.linalg.norm(steps, axis=0), before, after)


def _angular_speeds(motion: PoseTrajectory, window: float) -> Float64Array:
    if len(motion.times) < 2:
        return np.zeros(len(motion.times))
    before, after = _around(motion.times, window)
    ends = (rotations.interpolate(motion.times, motion.orientations, at) for at in (before, after))
    return _per_second(rotations.distance(*ends), before, after)


def _per_second(moved: Float64Array, before: Float64Array, after: Float64Array) -> Float64Array:
    spans = after - before
    return np.divide(moved, spans, out=np.zeros(len(moved)), where=spans > 0.0)


def _pieces(times: Float64Array, activity: Float64Array, pause: float) -> list[slice]:
    """Runs of samples that move, with half a pause around them, where one moves enough."""
    runs: list[list[int]] = []
    for start, stop in _runs(activity >= _HYSTERESIS):
        if runs and times[start] - times[runs[-1][1] - 1] < pause:
            runs[-1][1] = stop
        else:
            runs.append([start, stop])
    return [
        slice(
            int(np.searchsorted(times, times[start] - 0.5 * pause)),
            int(np.searchsorted(times, times[stop - 1] + 0.5 * pause, side="right")),
        )
        for start, stop in runs
        if (activity[start:stop] >= 1.0).any()
    ]


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Where True begins and ends, half open."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


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
