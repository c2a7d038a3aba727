"""Samples that jump away from their neighbours and back: faults of the sensor, not of the hand.

A sample is judged by its distance from the median around it, relative to the usual distances and
steps there. Of the steps the larger ones count, so that a hand that stops abruptly is no fault.
Source: after Hampel 1974, "The influence curve and its role in robust estimation".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array

_NEAR = 7  # samples of the median: up to three in a row may be wrong
_AROUND = 51  # samples whose distances and steps are the usual ones
_LARGER = 80  # percentile of the steps that counts; a few spikes stay above it
_TO_SIGMA = 1.4826  # standard deviation per median absolute deviation of a normal distribution
_TOGETHER = 1000  # samples whose windows are in memory at a time
_FLOOR = 1e-3  # fraction of a column's range; anything smaller is no spike


def spikes(values: Float64Array, factor: float) -> NDArray[np.bool_]:
    """Which rows (n,) of values (n, d) jump away from their neighbours."""
    if len(values) <= _NEAR:
        return np.zeros(len(values), dtype=bool)
    centre = _ranked(values, _NEAR, 50)
    off = np.abs(values - centre)
    steps = np.abs(np.diff(values, axis=0, append=values[-1:]))
    noise = _TO_SIGMA * _ranked(off, _AROUND, 50)
    pace = _ranked(steps, _AROUND, _LARGER)
    least = _FLOOR * np.ptp(centre, axis=0) + np.spacing(np.abs(centre).max(axis=0)) * _AROUND
    return np.asarray((off > factor * (noise + pace) + least).any(axis=1))


def _ranked(values: Float64Array, size: int, percent: int) -> Float64Array:
    """A percentile (n, d) of the samples around each, mirrored at the ends."""
    rank, beside = size * percent // 100, size // 2
    mirrored = np.pad(values, ((beside, beside), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(mirrored, size, axis=0)
    result = np.empty_like(values)
    for first in range(0, len(values), _TOGETHER):
        rows = slice(first, first + _TOGETHER)
        result[rows] = np.partition(windows[rows], rank)[..., rank]
    return result
