"""Cuts long recordings into motions at the pauses between them."""

from __future__ import annotations

from typing import cast

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, MotionT, as_demonstration
from leadthrough.rest import HYSTERESIS, runs, speeds_of, thresholds_of


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

    Raises:
        InvalidInput: if an argument is of the wrong type or not positive.
    """
    shown = as_demonstration(demonstration, "demonstration")
    window = check.number(pause, "pause", above=0.0)
    least = check.number(shortest, "shortest", above=0.0)
    motion = shown.motion
    speeds = speeds_of(motion, window)
    moving = speeds.in_multiples_of(thresholds_of(speeds, speed, angular_speed))
    pieces = [
        piece
        for piece in _pieces(motion.times, moving, window)
        if motion.times[piece.stop - 1] - motion.times[piece.start] >= least
    ]
    return [
        Demonstration(cast(MotionT, motion[piece]), name=f"{shown.name} {number}".strip())
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
