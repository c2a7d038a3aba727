"""How a motion runs along its path: the fraction of the path covered over normalised time."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import normalised_times
from leadthrough.preprocess.resample import arc_length

SAMPLES = 1001  # of progress, at evenly spaced normalised times
# Samples over which the speed is averaged twice: the acceleration becomes continuous, and recorded
# speeds lose their noise.
_SMOOTHED = 35
# Samples of long motions are so many s apart, or averages would take their rests away.
_MAX_STEP, _MAX_SAMPLES = 0.015, 1_000_000


def progress_of(times: Float64Array, path: Float64Array) -> Float64Array:
    """The fraction of a path covered at evenly spaced normalised times, (1001,) from 0 to 1."""
    covered = arc_length(path)
    fraction = covered / covered[-1] if covered[-1] > 0 else np.linspace(0.0, 1.0, len(path))
    return np.interp(np.linspace(0, 1, SAMPLES), normalised_times(times), fraction)


def sample_count(duration: float) -> int:
    """The number of samples of the progress of a motion, in s."""
    return max(SAMPLES, int(min(duration / _MAX_STEP, _MAX_SAMPLES)))


def uniform_progress() -> Float64Array:
    """Progress at constant speed, (1001,)."""
    return np.linspace(0.0, 1.0, SAMPLES)


def weighted_median(values: Float64Array, weights: Float64Array) -> float:
    """The median of values (k,) that count as much as their weights (k,)."""
    order = np.argsort(values, kind="stable")
    fraction = weights[order] / weights.sum()
    return float(np.interp(0.5, np.cumsum(fraction) - 0.5 * fraction, values[order]))


def speed_of(progress: Float64Array) -> Float64Array:
    """The smoothed change of a progress (1001,) from sample to sample, (1001,)."""
    from scipy.ndimage import uniform_filter1d

    speed = np.gradient(progress)
    for _ in range(2):
        speed = uniform_filter1d(speed, _SMOOTHED, mode="nearest")
    return np.asarray(speed)


def smoothed(progress: Float64Array) -> Float64Array:
    """The progress (m,), smoothed, with its own speeds at the start and at the end."""
    even, width = np.linspace(0.0, 1.0, len(progress)), _SMOOTHED
    ahead = progress - even
    # Mirrored through both ends, where it is 0, by as much as two averages take away.
    ahead = np.concatenate([-ahead[width - 1 : 0 : -1], ahead, -ahead[-2 : -width - 1 : -1]])
    for _ in range(2):
        ahead = np.convolve(ahead, np.full(width, 1.0 / width), mode="valid")
    return np.asarray(np.maximum.accumulate(np.clip(even + ahead, 0.0, 1.0)))
