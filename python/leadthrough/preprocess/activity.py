"""How fast a motion is at each of its samples, and when it rests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.motion import Motion, PoseTrajectory

# A motion that has begun may become slower than one that begins, by this factor.
HYSTERESIS = 0.5


def activity(motion: Motion, *, speed: float, angular_speed: float, window: float) -> Float64Array:
    """Mean speeds (n,) in multiples of a threshold; of poses the larger of the two multiples.

    At 1 and above a motion begins, below `HYSTERESIS` it rests.

    Args:
        motion: of n samples.
        speed: threshold, m/s, or the unit of the positions per second.
        angular_speed: threshold of poses, rad/s.
        window: s, over which speeds are averaged.
    """
    result = _speeds(motion, window) / speed
    if isinstance(motion, PoseTrajectory):
        result = np.maximum(result, _angular_speeds(motion, window) / angular_speed)
    return result


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The ranges of True in flags (n,), as indices of the first one and after the last one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def rests(
    motion: Motion, *, speed: float, angular_speed: float, pause: float
) -> list[tuple[float, float]]:
    """When the motion rests: start and end of each rest, s.

    Args:
        motion: of any type.
        speed: below half of which it rests, m/s, or the unit of the positions per second.
        angular_speed: below half of which poses rest, rad/s.
        pause: s, shortest rest that counts.
    """
    still = activity(motion, speed=speed, angular_speed=angular_speed, window=pause) < HYSTERESIS
    found = [(float(motion.times[a]), float(motion.times[b - 1])) for a, b in runs(still)]
    return [(start, end) for start, end in found if end - start >= pause]


def _around(times: Float64Array, window: float) -> tuple[Float64Array, Float64Array]:
    """The start and end of the window around each time, inside the recording."""
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
