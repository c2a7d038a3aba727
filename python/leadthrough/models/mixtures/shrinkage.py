"""Covariances of few demonstrations, shrunk towards round ones.

The samples of a demonstration deviate together, so that it counts once: two demonstrations show
one direction in which they differ, and say nothing of the others. Inverted as it is, such a
covariance is certain in those, and a product of two lies where they happen to cross.

Source: Murphy 2012, "Machine learning: a probabilistic perspective", section 4.6.2.
"""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array

# What a round covariance counts for, in demonstrations: as little as any.
_ROUND_COUNTS = 1.0
_ROTATION = 3  # columns at the end of those of poses


def shrunk(covariances: Float64Array, demonstrations: int, *, poses: bool) -> Float64Array:
    """Covariances of the time and the columns, those of the columns given the time made rounder."""
    fraction = _ROUND_COUNTS / (demonstrations - 1.0 + _ROUND_COUNTS)
    given_time = conditional(covariances)
    result = covariances.copy()
    result[:, 1:, 1:] += fraction * (round_ones(given_time, poses=poses) - given_time)
    return result


def conditional(covariances: Float64Array) -> Float64Array:
    """Covariances (k, d, d) of the columns, given the time."""
    rates = covariances[:, 0, 1:] / covariances[:, :1, 0]
    return np.asarray(covariances[:, 1:, 1:] - rates[:, :, None] * covariances[:, :1, 1:])


def round_ones(covariances: Float64Array, *, poses: bool) -> Float64Array:
    """Covariances (k, d, d) of the same variances in all directions."""
    size = covariances.shape[1]
    even = np.zeros_like(covariances)
    split = size - _ROTATION if poses else size
    for group in (np.arange(split), np.arange(split, size)):
        if len(group) > 0:
            variances = covariances[:, group, group].mean(axis=1)
            even[:, group, group] = variances[:, None]
    return even
