"""White noise of sampled paths, and paths without it.

A length summed over noisy samples grows with their number, not with the motion. The second
differences of white noise alternate in sign, those of a motion sampled finely enough do not:
these stay to the bit.
"""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array

# Noise s gives neighbouring second differences the covariance -4 s^2.
_COVARIANCE = -4.0
# A path of fewer samples is a polygon: its corners are meant, also where they alternate.
_MIN_SAMPLES = 20
_ROUNDING = 1e-9  # of the path's extent
_ORDER = 3  # of the differences that smoothing penalises: parabolas stay as they are
# log10 of the penalty: from too weak to change anything to as strong as rounding allows, which
# smooths over 200 samples. In a longer path it is that of a few windows.
_WEAKEST, _STRONGEST, _TOLERANCE = -3.0, 12.0, 1e-3
_MAX_SMOOTHED, _WINDOWS = 2000, 8
# Standard deviations by which hardly one of _MAX_SMOOTHED samples has noise longer than the mean.
_SPREAD = 3.0
# The steps of a random walk are unrelated to those before: all their correlations are near 0. Those
# of a motion with white noise are not: noise makes neighbouring steps turn back, the motion keeps
# steps farther apart alike. With fewer steps chance decides.
_MIN_STEPS, _LAGS = 50, 6
_NEIGHBOURS_UNRELATED, _OTHERS_UNRELATED = 0.25, 0.1


def noise_of(path: Float64Array) -> float:
    """Standard deviation of the white noise in each coordinate of a path; 0 for a smooth one."""
    if len(path) < _MIN_SAMPLES:
        return 0.0
    bends = np.diff(path, 2, axis=0)
    alternating = float((bends[1:] * bends[:-1]).mean())
    noise = float(np.sqrt(max(alternating / _COVARIANCE, 0.0)))
    return noise if noise > _ROUNDING * float(np.ptp(path, axis=0).max()) else 0.0


def is_random_walk(path: Float64Array) -> bool:
    """Whether the steps of a path (n, d), evenly sampled in time, are unrelated to each other."""
    steps = np.diff(path, axis=0)
    total = float((steps**2).sum())
    if len(steps) < _MIN_STEPS or total == 0.0:
        return False
    first, *others = (
        float((steps[lag:] * steps[:-lag]).sum()) / total for lag in range(1, _LAGS + 1)
    )
    unrelated = abs(float(np.mean(others))) < _OTHERS_UNRELATED
    return abs(first) < _NEIGHBOURS_UNRELATED and unrelated


def without_noise(path: Float64Array) -> Float64Array:
    """The path smoothed until what it loses is as large as its white noise, detail aside."""
    # Whittaker 1923, "On a new method of graduation"; the strength by Morozov's principle.
    noise = noise_of(path)
    if noise == 0.0:
        return path
    first = max(len(path) - _MAX_SMOOTHED, 0)
    starts = np.unique(np.linspace(0, first, _WINDOWS).astype(int)).tolist()
    windows = (path[start : start + _MAX_SMOOTHED] for start in starts)
    strengths = [_strength(window, own) for window in windows if (own := noise_of(window))]
    strength = float(np.median(strengths)) if strengths else _WEAKEST
    if strength <= _WEAKEST:
        return path
    lost = _smoothed(path, _penalty(len(path)), strength) - path
    # Of more samples some have longer noise: a Gaussian's tail falls with exp(-spread^2 / 2).
    spread = np.sqrt(_SPREAD**2 + 2.0 * np.log(max(len(path) / _MAX_SMOOTHED, 1.0)))
    most = noise * (np.sqrt(path.shape[1]) + spread)
    shares = most / np.maximum(np.linalg.norm(lost, axis=1), most)
    return np.asarray(path + shares[:, None] * lost)


def _strength(path: Float64Array, noise: float) -> float:
    """The strength of smoothing at which a path loses as much as its noise, > 0."""
    from scipy.optimize import brentq

    bands = _penalty(len(path))

    def excess(strength: float) -> float:
        lost = _smoothed(path, bands, strength) - path
        return float(np.sqrt((lost**2).mean())) / noise - 1.0

    if excess(_WEAKEST) >= 0.0:
        return _WEAKEST
    if excess(_STRONGEST) <= 0.0:
        return _STRONGEST
    return float(brentq(excess, _WEAKEST, _STRONGEST, xtol=_TOLERANCE))


def _penalty(count: int) -> Float64Array:
    """Lower bands (4, n) of D'D, with D the third differences of n samples."""
    weights = np.array([-1.0, 3.0, -3.0, 1.0])
    bands = np.zeros((_ORDER + 1, count))
    rows = count - _ORDER
    for below in range(_ORDER + 1):
        for column in range(_ORDER + 1 - below):
            bands[below, column : column + rows] += weights[column] * weights[column + below]
    return bands


def _smoothed(path: Float64Array, bands: Float64Array, strength: float) -> Float64Array:
    from scipy.linalg import solveh_banded

    system = 10.0**strength * bands
    system[0] += 1.0
    return np.asarray(solveh_banded(system, path, lower=True))
