"""How a motion runs along its path: the fraction of the path covered over normalised time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import normalised_times
from leadthrough.noise import without_noise
from leadthrough.preprocess.resample import arc_length
from leadthrough.trajectories import minimum_jerk_time_scaling

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

SAMPLES = 1001  # of progress, at evenly spaced normalised times
# Fractions of the duration. The speed is averaged twice over the first, which makes the
# acceleration continuous and takes the noise out of recorded speeds; it rises from rest and falls
# to rest within the second. Recordings are cut while the hand still moves: longer ramps would
# distort them.
_SMOOTHING = 0.035
_RAMP = 0.025


def progress_of(times: Float64Array, path: Float64Array) -> Float64Array:
    """The fraction of a path covered at evenly spaced normalised times, (1001,) from 0 to 1."""
    return _progress(times, without_noise(path))


def uniform_progress() -> Float64Array:
    """Progress at constant speed, (1001,)."""
    return np.linspace(0.0, 1.0, SAMPLES)


def progress_by_speed(path: Float64Array, speed: Float64Array) -> Float64Array:
    """Progress (1001,) along a path at a speed that is given."""
    pace = 1.0 / speed
    steps = np.diff(arc_length(path)) * 0.5 * (pace[1:] + pace[:-1])
    clock = np.concatenate([[0.0], np.cumsum(steps)])
    if clock[-1] == 0.0:
        return uniform_progress()
    rising = np.concatenate([[True], np.diff(clock) > 0.0])
    return _progress(clock[rising], path[rising])


def speed_of(progress: Float64Array) -> Float64Array:
    """The smoothed change of a progress (1001,) from sample to sample, (1001,)."""
    from scipy.ndimage import uniform_filter1d

    speed = np.gradient(progress)
    for _ in range(2):
        speed = uniform_filter1d(speed, int(_SMOOTHING * SAMPLES), mode="nearest")
    return np.asarray(speed)


def rest_to_rest(progress: Float64Array) -> Float64Array:
    """The progress (1001,), smoothed, starting and ending at rest."""
    u = np.linspace(0.0, 1.0, SAMPLES)
    x = np.clip(np.minimum(u, 1.0 - u) / _RAMP, 0.0, 1.0)
    speed = minimum_jerk_time_scaling(x, speed_of(progress))
    total = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return np.asarray(total / total[-1])


def smoothed(progress: Float64Array) -> Float64Array:
    """The progress (1001,), smoothed, with its own speeds at the start and at the end."""
    even = uniform_progress()
    ahead = progress - even
    width = int(_SMOOTHING * SAMPLES) | 1
    # Mirrored through both ends, where it is 0, by as much as two averages take away.
    ahead = np.concatenate([-ahead[width - 1 : 0 : -1], ahead, -ahead[-2 : -width - 1 : -1]])
    for _ in range(2):
        ahead = np.convolve(ahead, np.full(width, 1.0 / width), mode="valid")
    return np.asarray(np.maximum.accumulate(np.clip(even + ahead, 0.0, 1.0)))


def spline_of(progress: Float64Array) -> CubicSpline:
    """Progress (m,) at evenly spaced normalised times as a curve, its acceleration continuous."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(np.linspace(0.0, 1.0, len(progress)), progress, bc_type="clamped")


def covered_at(progress: CubicSpline, normalised_times: Float64Array) -> Float64Array:
    """The fraction of the path covered at any times."""
    return np.asarray(np.clip(progress(normalised_times), 0.0, 1.0))


def _progress(times: Float64Array, path: Float64Array) -> Float64Array:
    covered = arc_length(path)
    fraction = covered / covered[-1] if covered[-1] > 0 else np.linspace(0.0, 1.0, len(path))
    return np.interp(np.linspace(0, 1, SAMPLES), normalised_times(times), fraction)
