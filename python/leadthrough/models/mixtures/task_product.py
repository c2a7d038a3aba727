"""The components of a task-parameterised mixture where the frames of a situation stand.

Source: Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval", sections
2 to 4; here the time counts once and not once per frame.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.mixtures.em import Blocks
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.task_frames import Placed


def multiplied(components: Blocks, seen: Sequence[Placed]) -> Mixture:
    """The mixture of the time and the common columns, in a situation.

    A component's Gaussian is one of the time and, given the time, one of the columns in each
    frame; the latter are multiplied, which leaves their mean linear in the time.

    Args:
        components: components of the time, s, and the columns in each frame.
        seen: the components' Gaussians in each frame, carried into the common columns.

    Returns:
        Mixture of 1 + d columns, the time first, s.
    """
    size = seen[0].means.shape[1]
    precision = np.zeros((len(components.weights), size, size))
    pull = np.zeros((len(components.weights), size))
    slope = np.zeros_like(pull)
    for each, covariances in zip(seen, components.covariances, strict=True):
        rate = covariances[:, 0, 1:] / covariances[:, :1, 0]
        inner = covariances[:, 1:, 1:] - rate[:, :, None] * covariances[:, :1, 1:]
        own = np.asarray(np.linalg.inv(each.maps @ inner @ each.maps.transpose(0, 2, 1)))
        precision += own
        pull += _applied(own, each.means)
        slope += _applied(own, _applied(each.maps, rate) + each.drift)
    inner = np.asarray(np.linalg.inv(precision))
    rate = _applied(inner, slope)
    times, variances = components.means[0][:, 0], components.covariances[0][:, 0, 0]
    covariance = np.empty((len(times), size + 1, size + 1))
    covariance[:, 0, 0] = variances
    covariance[:, 0, 1:] = covariance[:, 1:, 0] = variances[:, None] * rate
    outer = rate[:, :, None] * rate[:, None, :] * variances[:, None, None]
    covariance[:, 1:, 1:] = 0.5 * (inner + inner.transpose(0, 2, 1)) + outer
    return Mixture(components.weights, np.column_stack([times, _applied(inner, pull)]), covariance)


def _applied(matrices: Float64Array, vectors: Float64Array) -> Float64Array:
    """Products (k, d) of matrices (k, d, d) with vectors (k, d)."""
    return np.asarray(np.einsum("kij,kj->ki", matrices, vectors))
