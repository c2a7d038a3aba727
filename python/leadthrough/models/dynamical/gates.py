"""Weights by which a system mixes linear ones: of Gaussians, or of sigmoids."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.repr import ShortRepr


class Gates(Protocol):
    """Weights of k linear systems, all >= 0 everywhere."""

    def weights(self, x: Float64Array) -> Float64Array:
        """Weights (n, k) at positions (n, d)."""


@dataclass(frozen=True, eq=False)
class GaussianGates(ShortRepr):
    """Probabilities of the k components of a Gaussian mixture: they sum to 1."""

    logits: Float64Array  # logarithms (k,) of the components' weights
    means: Float64Array  # means (k, d)
    whitening: Float64Array  # matrices (k, d, d) with whitening^T whitening the precision

    @staticmethod
    def of(weights: Float64Array, means: Float64Array, covariances: Float64Array) -> GaussianGates:
        """The gates of a mixture with weights (k,), means (k, d) and covariances (k, d, d)."""
        roots = np.linalg.inv(np.linalg.cholesky(covariances))
        return GaussianGates(np.log(weights), means, roots)

    def weights(self, x: Float64Array) -> Float64Array:
        """Weights (n, k) at positions (n, d)."""
        joint = monomials(x) @ self._coefficients
        joint -= joint.max(axis=1, keepdims=True)
        np.exp(joint, out=joint)
        joint /= joint.sum(axis=1, keepdims=True)
        return np.asarray(joint)

    def squared(self, x: Float64Array) -> Float64Array:
        """Squared Mahalanobis distances (n, k) of positions (n, d) from the means."""
        volume = np.linalg.slogdet(self.whitening)[1]
        return np.asarray(2.0 * (self.logits + volume - monomials(x) @ self._coefficients))

    @cached_property
    def _coefficients(self) -> Float64Array:
        """Coefficients (m, k) of the logarithms of the weights as sums of monomials."""
        precision = np.einsum("kij,kil->kjl", self.whitening, self.whitening)
        linear = np.einsum("kij,kj->ki", precision, self.means)
        volume = np.linalg.slogdet(self.whitening)[1]
        constant = self.logits + volume - 0.5 * (linear * self.means).sum(axis=1)
        rows, columns = np.triu_indices(self.means.shape[1])
        doubled = np.where(rows == columns, -0.5, -1.0)
        quadratic = precision[:, rows, columns] * doubled
        return np.ascontiguousarray(np.hstack([constant[:, None], linear, quadratic]).T)


@dataclass(frozen=True, eq=False)
class SigmoidGates(ShortRepr):
    """A constant 1 and m sigmoids of random directions: the hidden layer of a network."""

    directions: Float64Array  # rows (m, d) of the hidden layer's matrix
    offsets: Float64Array  # offsets (m,) of the hidden layer

    def weights(self, x: Float64Array) -> Float64Array:
        """Weights (n, 1 + m) at positions (n, d)."""
        raised = x @ self.directions.T + self.offsets
        return np.hstack([np.ones((len(x), 1)), 0.5 + 0.5 * np.tanh(0.5 * raised)])


def monomials(x: Float64Array) -> Float64Array:
    """1, x_i and, for i <= j, x_i x_j of points (n, d)."""
    rows, columns = np.triu_indices(x.shape[1])
    return np.hstack([np.ones((len(x), 1)), x, x[:, rows] * x[:, columns]])


def squared_distances(x: Float64Array, centres: Float64Array) -> Float64Array:
    """Squared distances (n, k) of positions (n, d) from centres (k, d)."""
    mixed = x @ centres.T
    squared = (x**2).sum(axis=1)[:, None] - 2.0 * mixed + (centres**2).sum(axis=1)
    return np.asarray(np.maximum(squared, 0.0))
