"""Demonstrations at an even rate, and smoothed ones with their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator, make_smoothing_spline
from scipy.signal import savgol_filter

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event, Events
from leadthrough.motion import Demonstration, JointTrajectory, Motion, PoseTrajectory

_DEGREE = 3
_FEWEST = 5  # samples that a cubic is fitted to, one more than it goes through
_MOST = 10_000_000

# Values (n, d) of the derivative, 0 to 2, of columns (n, d).
_Smoother = Callable[[Float64Array, int], Float64Array]


def sample_evenly(demonstration: Demonstration, *, rate: float) -> Demonstration:
    """The demonstration at even steps from its first sample on, to less than a step from its last.

    rate: Hz, > 0. Positions, and velocities where there are some, follow monotone cubics (Fritsch
    and Carlson 1980), which never leave the range of their neighbours; orientations turn at
    constant velocity between theirs. Raises InvalidInput.
    """
    motion, hertz = _checked(demonstration), check.number(rate, "rate", above=0.0)
    if motion.duration * hertz > _MOST:
        raise InvalidInput(f"rate: expected at most {_MOST:,} samples, got {rate} Hz")
    count = int(np.floor(motion.duration * hertz + 1e-9)) + 1
    clock = np.minimum(motion.times[0] + np.arange(count) / hertz, motion.times[-1])
    parts: dict[str, Any] = {"times": clock, "events": clipped(motion.events, clock)}
    for name in ("positions", "velocities", "accelerations"):
        if getattr(motion, name, None) is not None:
            parts[name] = PchipInterpolator(motion.times, getattr(motion, name))(clock)
    if isinstance(motion, PoseTrajectory):
        parts["orientations"] = rotations.interpolate(motion.times, motion.orientations, clock)
    return replace(demonstration, motion=replace(motion, **parts))


def smooth_motion(demonstration: Demonstration, *, window: float) -> Demonstration:
    """The demonstration without trembling shorter than a window, s, > 0.

    By local cubics (Savitzky and Golay 1964): a joint's velocity and acceleration are theirs. The
    samples have to be even, as `sample_evenly` makes them. Raises InvalidInput.
    """
    motion, span = _checked(demonstration), check.number(window, "window", above=0.0)
    steps = np.diff(motion.times)
    step = motion.duration / len(steps)
    if np.abs(steps - step).max() > 1e-3 * step:
        raise InvalidInput("demonstration: expected even steps; sample_evenly makes them")
    length = 2 * round(min(span / step, 2.0 * len(steps)) / 2.0) + 1
    if not _FEWEST <= length <= len(motion.times):
        raise InvalidInput(
            f"window: expected {_FEWEST} samples or more, not more than there are, "
            f"{(_FEWEST - 1) * step:.6g} to {motion.duration:.6g} s, got {span:.6g} s"
        )
    return _smoothed(
        demonstration,
        lambda columns, order: np.asarray(
            savgol_filter(columns, length, _DEGREE, deriv=order, delta=step, axis=0)
        ),
    )


def smooth_by_spline(
    demonstration: Demonstration, *, stiffness: float | None = None
) -> Demonstration:
    """The demonstration on cubic smoothing splines, which also give a joint's derivatives.

    stiffness: weight of the squared second derivative over that of the squared distances from the
    samples, >= 0; left out, it is found for each column by generalised cross-validation (Craven
    and Wahba 1979). The samples need not be even. Raises InvalidInput.
    """
    motion = _checked(demonstration)
    if len(motion.times) < _FEWEST:
        raise InvalidInput(f"demonstration: expected at least {_FEWEST} samples")
    weight = None if stiffness is None else check.number(stiffness, "stiffness", at_least=0.0)
    own = motion.times - motion.times[0]

    def smoothed(columns: Float64Array, order: int) -> Float64Array:
        splines = [make_smoothing_spline(own, each, lam=weight) for each in columns.T]
        return np.column_stack([spline(own, order) for spline in splines])

    return _smoothed(demonstration, smoothed)


def clipped(happened: Events, clock: Float64Array) -> Events:
    """The events, those outside of a clock at its ends."""
    return tuple(
        Event(float(np.clip(event.time, clock[0], clock[-1])), event.name) for event in happened
    )


def _checked(demonstration: Demonstration) -> Motion:
    if not isinstance(demonstration, Demonstration):
        got = type(demonstration).__name__
        raise InvalidInput(f"demonstration: expected a Demonstration, got {got}")
    if len(demonstration.motion.times) < 2:
        raise InvalidInput("demonstration: expected at least two samples, got one")
    return demonstration.motion


def _smoothed(demonstration: Demonstration, smoother: _Smoother) -> Demonstration:
    motion = demonstration.motion
    parts: dict[str, Any] = {"positions": smoother(motion.positions, 0)}
    if isinstance(motion, JointTrajectory):
        parts["velocities"] = smoother(motion.positions, 1)
        parts["accelerations"] = smoother(motion.positions, 2)
    elif isinstance(motion, PoseTrajectory):
        # Between near quaternions the shortest way is straight but for the square of the angle.
        turned = smoother(motion.orientations, 0)
        parts["orientations"] = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return replace(demonstration, motion=replace(motion, **parts))
