"""Smooth motions with their derivatives, and smooth paths from grids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    MotionT,
    PoseTrajectory,
    fields_of,
    joints_with,
    rows_of,
)
from leadthrough.preprocess.resample import arc_length, by_arc_length, several_samples

_SAMPLES_PER_KNOT = 6
# Weight of both end points, so large that moving the end coefficients onto them changes nothing
# else.
_END_WEIGHT = 1e3
_HALVINGS = 4
_DEGREE = 3
_FITTED = 5  # samples that a cubic is fitted to, one more than it can pass through
_UNEVEN = 1e-3  # of a step; rounding in a file's times stays below


# Values (n, d) of the derivative of order 0, 1 or 2 of columns (n, d).
_Smoother = Callable[[Float64Array, int], Float64Array]


def smooth_motion(
    demonstration: Demonstration[MotionT] | MotionT, *, window: float
) -> Demonstration[MotionT]:
    """The demonstration without trembling shorter than a window.

    Local cubics are fitted to the samples, and give joint motions their velocities and
    accelerations.

    Args:
        demonstration: evenly spaced samples, as `sample_evenly` makes them; a motion stands for a
            demonstration of it.
        window: s, at least four steps, at most the duration.

    Raises:
        InvalidInput: if samples are not evenly spaced, or the window is too short or too long.

    Source: Savitzky and Golay 1964.
    """
    return smoothed_over(demonstration, window, "window")


def smoothed_over(
    demonstration: Demonstration[MotionT] | MotionT, window: float, name: str
) -> Demonstration[MotionT]:
    """The demonstration smoothed as by `smooth_motion`, whose window is called `name` in errors."""
    demonstration = several_samples(demonstration)
    motion, span = demonstration.motion, check.number(window, name, above=0.0)
    steps = np.diff(motion.times)
    step = motion.duration / len(steps)
    if np.abs(steps - step).max() > _UNEVEN * step:
        raise InvalidInput(
            "demonstration: expected evenly spaced times; `leadthrough clean --new-rate` makes "
            "them, in Python preprocess.sample_evenly"
        )
    length = 2 * round(min(span / step, 2.0 * len(steps)) / 2.0) + 1
    if not _FITTED <= length <= len(motion.times):
        raise InvalidInput(
            f"{name}: expected {(_FITTED - 1) * step:.6g} to {motion.duration:.6g} s, at least "
            f"{_FITTED} samples and at most all, got {span:.6g} s"
        )
    return _smoothed(demonstration, _local_cubics(length, step))


def smooth_by_spline(
    demonstration: Demonstration[MotionT] | MotionT, *, stiffness: float | None = None
) -> Demonstration[MotionT]:
    """The demonstration on cubic smoothing splines, which give joint motions their derivatives.

    Args:
        demonstration: at least five samples, not necessarily evenly spaced; a motion stands for a
            demonstration of it.
        stiffness: weight, >= 0, of the squared second derivative relative to the squared distances
            from the samples; by default found for each column by generalised cross-validation.

    Source: Craven and Wahba 1979.
    """
    demonstration = several_samples(demonstration)
    times = demonstration.motion.times
    if len(times) < _FITTED:
        raise InvalidInput(f"demonstration: expected at least {_FITTED} samples, got {len(times)}")
    weight = None if stiffness is None else check.number(stiffness, "stiffness", at_least=0.0)
    return _smoothed(demonstration, _splines(times - times[0], weight))


def smooth_path(
    path: Float64Array,
    *,
    knot_spacing: float,
    accept: Callable[[Float64Array], bool] = lambda points: True,  # noqa: ARG005
) -> Float64Array:
    """Dense samples of a C2 curve close to a path, with the same end points."""
    length = arc_length(path)[-1]
    if length == 0.0:
        return path
    for halving in range(_HALVINGS + 1):
        pieces = int(np.ceil(length / knot_spacing)) * 2**halving
        pieces = max(pieces, 1)
        candidate = in_pieces(by_arc_length(path, _SAMPLES_PER_KNOT * pieces + 1), pieces)
        if accept(candidate):
            return candidate
    return path


def in_pieces(samples: Float64Array, pieces: int) -> Float64Array:
    """Samples (n, d) of the C2 curve of so many cubic pieces that is closest to others."""
    phase = np.linspace(0.0, 1.0, len(samples))
    inner = np.linspace(0.0, 1.0, pieces + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
    weights = np.ones(len(samples))
    weights[[0, -1]] = _END_WEIGHT
    from scipy.interpolate import make_lsq_spline

    spline = make_lsq_spline(phase, samples, knots, k=_DEGREE, w=weights)
    spline.c[[0, -1]] = samples[[0, -1]]
    return np.asarray(spline(phase))


def _local_cubics(length: int, step: float) -> _Smoother:
    from scipy.signal import savgol_filter

    def smoothed(columns: Float64Array, order: int) -> Float64Array:
        fitted = savgol_filter(columns, length, _DEGREE, deriv=order, delta=step, axis=0)
        return np.asarray(fitted)

    return smoothed


def _splines(times: Float64Array, weight: float | None) -> _Smoother:
    from scipy.interpolate import make_smoothing_spline

    def smoothed(columns: Float64Array, order: int) -> Float64Array:
        splines = [make_smoothing_spline(times, each, lam=weight) for each in columns.T]
        return np.column_stack([spline(times, order) for spline in splines])

    return smoothed


def _smoothed(demonstration: Demonstration[MotionT], smoother: _Smoother) -> Demonstration[MotionT]:
    motion = demonstration.motion
    rows: dict[str, Any] = {"positions": smoother(motion.positions, 0)}
    if isinstance(motion, JointTrajectory):
        rows["velocities"] = smoother(motion.positions, 1)
        rows["accelerations"] = smoother(motion.positions, 2)
    elif isinstance(motion, PoseTrajectory):
        # Between nearby quaternions the shortest way is straight to first order in the angle.
        orientations = smoother(motion.orientations, 0)
        rows["orientations"] = orientations / np.linalg.norm(orientations, axis=1, keepdims=True)
    if joints_with(motion) is not None:
        rows["joints"] = smoother(rows_of(motion)["joints"], 0)
    return replace(demonstration, motion=replace(motion, **fields_of(motion, rows)))
