"""Samples that leap away from their neighbours and back: a sensor's faults, not the hand's.

After Hampel 1974, "The influence curve and its role in robust estimation": a sample is judged by
its distance from the median about it, in multiples of what distances and steps are there. Of the
steps the larger ones count, so that a hand that stops short is no fault.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, percentile_filter

from leadthrough.check import Float64Array

_NEAR = 7  # samples of the median: up to three in a row may be wrong
_AROUND = 51  # samples that tell what is usual
_LARGER = 80  # percent of the steps are smaller; a few spikes are not among them
_TO_SIGMA = 1.4826  # of the median distance of a normal distribution
_FLOOR = 1e-3  # of a column's extent: what is smaller is no spike


def spikes(values: Float64Array, factor: float) -> NDArray[np.bool_]:
    """Which rows (n,) of values (n, d) leap away by `factor` times what is usual about them."""
    if len(values) <= _NEAR:
        return np.zeros(len(values), dtype=bool)
    centre = median_filter(values, size=(_NEAR, 1), mode="mirror")
    off = np.abs(values - centre)
    steps = np.abs(np.diff(values, axis=0, append=values[-1:]))
    noise = _TO_SIGMA * median_filter(off, size=(_AROUND, 1), mode="mirror")
    pace = percentile_filter(steps, _LARGER, size=(_AROUND, 1), mode="mirror")
    least = _FLOOR * np.ptp(centre, axis=0) + np.spacing(np.abs(centre).max(axis=0)) * _AROUND
    return np.asarray((off > factor * (noise + pace) + least).any(axis=1))
