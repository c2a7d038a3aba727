"""Motions sampled evenly in time, and curves sampled evenly in arc length."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import (
    Demonstration,
    Event,
    JointTrajectory,
    MotionT,
    PoseTrajectory,
    as_demonstration,
    clipped_events,
    events_within,
    fields_of,
    lerp,
    rows_of,
)

_ENDLESS = "points: expected a curve of finite length; use a larger unit"
_MAX_SAMPLES = 10_000_000  # samples
_MIN_GAP = 1e-5  # s, between samples where a motion is cut


def arc_length(points: ArrayLike) -> Float64Array:
    """Lengths (n,) of the polygonal line through points, from the first one to each, from 0 on."""
    lengths = core.arc_lengths(_curve(points))
    if not np.isfinite(lengths[-1]):
        raise InvalidInput(_ENDLESS)
    return lengths


def by_arc_length(points: ArrayLike, count: int) -> Float64Array:
    """Points (count, d), evenly spaced in arc length along the polygonal line through others."""
    curve = _curve(points)
    even = core.by_arc_length(curve, check.integer(count, "count", at_least=2))
    if even is None:
        raise InvalidInput(_ENDLESS)
    return even


def _curve(points: ArrayLike) -> Float64Array:
    """At least one point (n, d)."""
    curve = check.array(points, "points", shape=("n", "d"))
    if len(curve) == 0:
        raise InvalidInput("points: expected at least one point, got none")
    if curve.shape[1] == 0:
        raise InvalidInput("points: expected at least one coordinate, got points without any")
    return curve


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

    demonstration = several_samples(demonstration)
    motion, hertz = demonstration.motion, check.number(rate, "rate", above=0.0)
    check_sample_count(motion.duration, hertz)
    count = int(np.floor(motion.duration * hertz + 1e-9)) + 1
    times = np.minimum(motion.times[0] + np.arange(count) / hertz, motion.times[-1])
    parts: dict[str, Any] = {
        name: PchipInterpolator(motion.times, values)(times)
        for name, values in rows_of(motion).items()
        if name != "orientations"
    }
    if isinstance(motion, PoseTrajectory):
        parts["orientations"] = rotations.interpolate(motion.times, motion.orientations, times)
    parts["events"] = clipped_events(motion.events, times)
    return replace(demonstration, motion=replace(motion, times=times, **fields_of(motion, parts)))


def check_sample_count(duration: float, rate: float) -> None:
    """Refuses a rate, Hz, at which a duration, s, has more samples than anyone needs."""
    if duration * rate > _MAX_SAMPLES:
        raise InvalidInput(
            f"rate: expected at most {_MAX_SAMPLES:,} samples in {duration:.6g} s, got {rate} Hz"
        )


def several_samples(demonstration: Demonstration[MotionT] | MotionT) -> Demonstration[MotionT]:
    demonstration = as_demonstration(demonstration, "demonstration")
    if len(demonstration.motion.times) < 2:
        raise InvalidInput("demonstration: expected at least two samples, got one")
    return demonstration


def trimmed(motion: JointTrajectory, first: float, last: float) -> JointTrajectory:
    """The part of a motion between two times, s from its start; the last event before it stays."""
    times = motion.times - motion.times[0]
    inside = times[(times > first + _MIN_GAP) & (times < last - _MIN_GAP)]
    if len(inside) < 1:
        raise InvalidInput(f"motion: too little is left between {first:.2f} and {last:.2f} s")
    kept = np.concatenate([[first], inside, [last]])
    rows = {name: lerp(kept, times, each) for name, each in rows_of(motion).items()}
    begin, end = motion.times[0] + np.array([first, last])
    before = [Event(begin, each.name) for each in motion.events if each.time < begin][-1:]
    events = (*before, *events_within(motion.events, begin, end))
    shifted = tuple(Event(each.time - begin, each.name) for each in events)
    return replace(motion, times=kept - first, events=shifted, **fields_of(motion, rows))
