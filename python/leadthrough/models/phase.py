"""How a motion runs along its path: progress over time, learned from demonstrations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d

from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length

_SAMPLES = 1001
# Share of the duration over which the speed is averaged, twice: it makes the acceleration
# continuous and takes the sampling noise out of recorded speeds.
_SMOOTHING = 0.05


def mean_progress(times: Sequence[Float64Array], paths: Sequence[Float64Array]) -> Float64Array:
    """Mean share of the path covered at evenly spaced normalised times, (1001,) from 0 to 1.

    times: each (n,) s. paths: each (n, d). The speed is smoothed and vanishes at both ends, so
    that the motion starts and ends at rest. Paths without length count as a uniform motion.
    """
    normalised = np.linspace(0.0, 1.0, _SAMPLES)
    progress = np.zeros(_SAMPLES)
    for stamps, points in zip(times, paths, strict=True):
        covered = arc_length(points)
        share = covered / covered[-1] if covered[-1] > 0 else np.linspace(0.0, 1.0, len(points))
        progress += np.interp(normalised, (stamps - stamps[0]) / (stamps[-1] - stamps[0]), share)
    return _rest_to_rest(progress / len(paths))


def uniform_progress() -> Float64Array:
    """Progress at constant speed but for short ramps from and to rest, (1001,)."""
    return _rest_to_rest(np.linspace(0.0, 1.0, _SAMPLES))


def progress_at(progress: Float64Array, normalised_times: Float64Array) -> Float64Array:
    """Share of the path covered at normalised times in [0, 1], with a continuous acceleration."""
    knots = np.linspace(0.0, 1.0, len(progress))
    spline = CubicSpline(knots, progress, bc_type="clamped")
    return np.asarray(np.clip(spline(normalised_times), 0.0, 1.0))


def _rest_to_rest(progress: Float64Array) -> Float64Array:
    speed = np.gradient(progress)
    width = int(_SMOOTHING * _SAMPLES)
    # Zeros beyond the ends let both averages fall to rest inside the motion.
    speed[:width] = speed[-width:] = 0.0
    for _ in range(2):
        speed = uniform_filter1d(speed, width, mode="constant")
    total = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return np.asarray(total / total[-1])
