"""Demonstrations at a constant rate."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import check, events, rotations
from leadthrough.errors import InvalidInput
from leadthrough.motion import Demonstration, MotionT, PoseTrajectory, fields_of, rows_of
from leadthrough.preprocess.rows import several_samples

_MAX_SAMPLES = 10_000_000  # samples


def sample_evenly(
    demonstration: Demonstration[MotionT] | MotionT, *, rate: float
) -> Demonstration[MotionT]:
    """The demonstration at evenly spaced times, from its first sample on.

    Its last sample comes less than a step before the old one. Positions, velocities and
    accelerations follow monotone cubics (Fritsch and Carlson 1980), which never leave the range of
    neighbouring samples; orientations turn at constant velocity between samples.

    Args:
        demonstration: at least two samples; a motion stands for a demonstration of it.
        rate: Hz, > 0.

    Raises:
        InvalidInput: if there is a single sample, or the rate is not positive or too high.
    """
    from scipy.interpolate import PchipInterpolator

    shown = several_samples(demonstration)
    motion, hertz = shown.motion, check.number(rate, "rate", above=0.0)
    if motion.duration * hertz > _MAX_SAMPLES:
        raise InvalidInput(
            f"rate: expected at most {_MAX_SAMPLES:,} samples in {motion.duration:.6g} s, "
            f"got {rate} Hz"
        )
    count = int(np.floor(motion.duration * hertz + 1e-9)) + 1
    times = np.minimum(motion.times[0] + np.arange(count) / hertz, motion.times[-1])
    parts: dict[str, Any] = {
        name: PchipInterpolator(motion.times, values)(times)
        for name, values in rows_of(motion).items()
        if name != "orientations"
    }
    if isinstance(motion, PoseTrajectory):
        parts["orientations"] = rotations.interpolate(motion.times, motion.orientations, times)
    parts["events"] = events.clipped(motion.events, times)
    return replace(shown, motion=replace(motion, times=times, **fields_of(motion, parts)))
