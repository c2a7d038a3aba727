"""Motions without the standing still before and after them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np

from leadthrough import check, events
from leadthrough.activity import HYSTERESIS, runs, speeds_of, thresholds_of
from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, Motion, MotionT, as_demonstration

# s: a short window finds the beginning to a tenth of a second; noise may need a longer one.
_WINDOWS = (0.2, 0.3, 0.5)


def trim(
    demonstration: Demonstration[MotionT] | MotionT,
    *,
    rest: float = 0.0,
    speed: float | None = None,
    angular_speed: float | None = None,
) -> Demonstration[MotionT]:
    """The demonstration without the standing still at both ends; pauses within it stay.

    The motion goes from where one of its speeds exceeds half its threshold for the first time to
    where it does so for the last time, provided that it exceeds the threshold itself in between.
    Speeds are slopes over 0.2 s, of noisy recordings over up to 0.5 s: some 0.1 s of rest may stay.
    Times are as recorded; events before and after come with the first and the last sample. What
    never moves stays whole.

    Args:
        demonstration: what was shown; a motion stands for a demonstration of it.
        rest: s of standing still to keep before and after, >= 0; infinite keeps all of it.
        speed: threshold, > 0, m/s, or the unit of the positions per second; of joints the norm over
            all of them, rad/s. By default it follows from the recording: twice what its noise
            reaches, and at least 4 % of its usual speed.
        angular_speed: threshold of poses, > 0, rad/s; by default as for `speed`.

    Raises:
        InvalidInput: if an argument is of the wrong type or out of its range.
    """
    shown = as_demonstration(demonstration, "demonstration")
    motion = shown.motion
    spare = rest if rest == math.inf else check.number(rest, "rest", at_least=0.0)
    # Numbers of a damaged file, whose squares overflow, have no speed: the motion stays whole.
    with np.errstate(over="ignore", invalid="ignore"):
        moving = _moving(motion, speed, angular_speed)
    found = [
        (first, after)
        for first, after in runs(moving >= HYSTERESIS)
        if (moving[first:after] >= 1.0).any()
    ]
    if not found:
        return shown
    first, last = motion.times[found[0][0]] - spare, motion.times[found[-1][1] - 1] + spare
    samples = slice(
        int(np.searchsorted(motion.times, first)),
        int(np.searchsorted(motion.times, last, side="right")),
    )
    piece = cast(MotionT, motion[samples])
    kept = replace(piece, events=events.clipped(motion.events, piece.times))
    return replace(shown, motion=kept)


def _moving(motion: Motion, speed: float | None, angular_speed: float | None) -> Float64Array:
    """Speeds (n,) in multiples of their thresholds, by the shortest window that noise allows."""
    for window in _WINDOWS:
        speeds = speeds_of(motion, window)
        if not speeds.drowned:
            break
    return speeds.in_multiples_of(thresholds_of(speeds, speed, angular_speed))


def standstill(whole: Motion, trimmed: Motion) -> tuple[float, float]:
    """How long a motion stood still before and after what `trim` left of it, s."""
    return (
        float(trimmed.times[0] - whole.times[0]),
        float(whole.times[-1] - trimmed.times[-1]),
    )
