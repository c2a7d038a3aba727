"""The components of a task-parameterised mixture where the frames of a situation stand.

A product of Gaussians that are thin in nearly the same direction lies where they cross, which may
be far from all of them: with few demonstrations a frame turned by a milliradian moved the mean by
metres. So the weights of the frames' means come from covariances that are mixed with round ones,
as much as it takes to keep the mean near the frames' means.

Source: Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval", sections
2 to 4; here the time counts once and not once per frame.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.gaussians.em import Blocks
from leadthrough.models.gaussians.mixture import Mixture
from leadthrough.models.mixtures.shrinkage import conditional, round_ones
from leadthrough.models.mixtures.task_frames import Placed

# A frame that moves takes the mean along by no more than this many times its own way.
_MOST_GAIN = 1.2
# Fractions of round covariances to try, the least that keeps the gain. Round ones alone give every
# frame a weight between 0 and 1.
_ROUND = (0.0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0)
_ROTATION = 3  # columns at the end of those of poses


def multiplied(components: Blocks, seen: Sequence[Placed], *, poses: bool) -> Mixture:
    """The mixture of the time and the common columns, in a situation."""
    rates, inner = [], []
    for each, covariances in zip(seen, components.covariances, strict=True):
        rate = covariances[:, 0, 1:] / covariances[:, :1, 0]
        rates.append(_applied(each.maps, rate) + each.drift)
        inner.append(each.maps @ conditional(covariances) @ each.maps.transpose(0, 2, 1))
    weights = _weights(inner, _units(seen, poses=poses), poses=poses)
    means = _combined(weights, [each.means for each in seen])
    slope = _combined(weights, rates)
    within = np.asarray(np.linalg.inv(np.sum([np.linalg.inv(each) for each in inner], axis=0)))
    times, variances = components.means[0][:, 0], components.covariances[0][:, 0, 0]
    covariance = np.empty((len(times), len(within[0]) + 1, len(within[0]) + 1))
    covariance[:, 0, 0] = variances
    covariance[:, 0, 1:] = covariance[:, 1:, 0] = variances[:, None] * slope
    outer = slope[:, :, None] * slope[:, None, :] * variances[:, None, None]
    covariance[:, 1:, 1:] = 0.5 * (within + within.transpose(0, 2, 1)) + outer
    return Mixture(components.weights, np.column_stack([times, means]), covariance)


def _weights(
    covariances: Sequence[Float64Array], units: Float64Array, *, poses: bool
) -> list[Float64Array]:
    """The matrices (k, d, d) by which the frames' means count; they sum to one."""
    scaled = [each / units / units[:, None] for each in covariances]
    rounds = [round_ones(each, poses=poses) for each in scaled]
    chosen = _products(scaled)
    done = np.zeros(len(scaled[0]), dtype=bool)
    for fraction in _ROUND:
        mixed = [
            (1.0 - fraction) * own + fraction * even
            for own, even in zip(scaled, rounds, strict=True)
        ]
        tried = _products(mixed)
        gains = np.max([np.linalg.norm(each, ord=2, axis=(1, 2)) for each in tried], axis=0)
        fits = ~done & ((gains <= _MOST_GAIN) | (fraction == 1.0))
        for each, better in zip(chosen, tried, strict=True):
            each[fits] = better[fits]
        done |= fits
        if done.all():
            break
    return [each * units[:, None] / units for each in chosen]


def _products(covariances: Sequence[Float64Array]) -> list[Float64Array]:
    """The weights (k, d, d) of the means in a product of Gaussians."""
    precisions = [np.asarray(np.linalg.inv(each)) for each in covariances]
    total = np.asarray(np.linalg.inv(np.sum(precisions, axis=0)))
    return [total @ each for each in precisions]


def _units(seen: Sequence[Placed], *, poses: bool) -> Float64Array:
    """Lengths (d,) that count alike: the motion's extent, for a rotation one radian."""
    size = seen[0].means.shape[1]
    units = np.ones(size)
    split = size - _ROTATION if poses else size
    if poses:
        extent = float(np.linalg.norm(np.ptp(seen[0].means[:, :split], axis=0)))
        units[:split] = extent or 1.0
    return units


def _combined(weights: Sequence[Float64Array], vectors: Sequence[Float64Array]) -> Float64Array:
    """The sum (k, d) of vectors of each frame, weighted."""
    parts = [_applied(w, each) for w, each in zip(weights, vectors, strict=True)]
    return np.asarray(np.sum(parts, axis=0))


def _applied(matrices: Float64Array, vectors: Float64Array) -> Float64Array:
    """Products (k, d) of matrices (k, d, d) with vectors (k, d)."""
    return np.asarray(np.einsum("kij,kj->ki", matrices, vectors))
