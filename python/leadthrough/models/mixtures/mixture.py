"""Gaussian mixtures and the regression with them.

Sources: Ghahramani and Jordan 1994, "Supervised learning from incomplete data via an EM approach";
Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval", section 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_SUM_TOLERANCE = 1e-6  # of weights that were rounded in a file


@dataclass(frozen=True, eq=False)
class Mixture:
    """weights: (k,) > 0, of sum 1. means: (k, d). covariances: (k, d, d), positive definite."""

    weights: Float64Array
    means: Float64Array
    covariances: Float64Array

    def __post_init__(self) -> None:
        weights = check.frozen(self.weights, "weights", shape=("k",))
        means = check.frozen(self.means, "means", shape=(len(weights), "d"))
        size = means.shape[1]
        covariances = check.frozen(
            self.covariances, "covariances", shape=(len(weights), size, size)
        )
        if not (weights >= 0.0).all() or abs(weights.sum() - 1.0) > _SUM_TOLERANCE:
            raise InvalidInput(f"weights: expected shares of sum 1, got {weights}")
        for name, value in (("weights", weights), ("means", means), ("covariances", covariances)):
            object.__setattr__(self, name, value)
        _ = self._whitening  # a covariance that is not positive definite is refused here

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.weights)

    @property
    def size(self) -> int:
        """Number of columns."""
        return int(self.means.shape[1])

    def log_density(self, points: Any) -> Float64Array:
        """Logarithms (n,) of the density at points (n, d). Raises InvalidInput."""
        data = check.array(points, "points", shape=("n", self.size))
        return _log_sum(self._joint(data))

    def responsibilities(self, points: Any) -> Float64Array:
        """Probability (n, k) that points (n, d) belong to each component. Raises InvalidInput."""
        joint = self._joint(check.array(points, "points", shape=("n", self.size)))
        return np.asarray(np.exp(joint - _log_sum(joint)[:, None]))

    def sample(self, count: int, *, seed: int) -> Float64Array:
        """Random points (count, d). Raises InvalidInput."""
        size = check.integer(count, "count", at_least=1)
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        which = rng.choice(self.count, size, p=self.weights / self.weights.sum())
        normal = rng.standard_normal((size, self.size))
        roots = np.linalg.cholesky(self.covariances)
        return np.asarray(self.means[which] + np.einsum("nij,nj->ni", roots[which], normal))

    def marginal(self, columns: Sequence[int]) -> Mixture:
        """The mixture of some columns, in the order given. Raises InvalidInput."""
        chosen = self._columns(columns, "columns")
        covariances = self.covariances[:, chosen][:, :, chosen]
        return Mixture(self.weights, self.means[:, chosen], covariances)

    def regress(
        self, values: Any, *, inputs: Sequence[int], outputs: Sequence[int] | None = None
    ) -> tuple[Float64Array, Float64Array]:
        """Mean (n, p) and covariance (n, p, p) of outputs given the values (n, m) of inputs.

        inputs, outputs: columns; by default all others are outputs. The covariance is that of the
        conditional mixture, by the law of total variance. Raises InvalidInput.
        """
        given = self._columns(inputs, "inputs")
        rest = [column for column in range(self.size) if column not in given]
        wanted = rest if outputs is None else self._columns(outputs, "outputs")
        if not wanted or set(wanted) & set(given):
            raise InvalidInput(f"outputs: expected columns beside the inputs, got {wanted}")
        x = check.array(values, "values", shape=("n", len(given)))
        return self._conditioned(x, given, wanted)

    def _conditioned(
        self, x: Float64Array, given: list[int], wanted: list[int]
    ) -> tuple[Float64Array, Float64Array]:
        of_inputs = self.covariances[:, given][:, :, given]
        whitening = np.linalg.inv(np.linalg.cholesky(of_inputs))
        joint = _log_joint(self.weights, self.means[:, given], whitening, x)
        shares = np.exp(joint - _log_sum(joint)[:, None])
        cross = self.covariances[:, wanted][:, :, given]
        gains = cross @ whitening.transpose(0, 2, 1) @ whitening
        inner = self.covariances[:, wanted][:, :, wanted] - gains @ cross.transpose(0, 2, 1)
        offsets = x[None] - self.means[:, None, given]
        means = self.means[:, None, wanted] + offsets @ gains.transpose(0, 2, 1)  # (k, n, p)
        mean = np.einsum("nk,knp->np", shares, means)
        # The spread of the components' means about their mean, free of cancellation.
        apart = (means - mean).transpose(1, 2, 0)
        within = shares @ inner.reshape(self.count, -1)
        covariance = (apart * shares[:, None, :]) @ apart.transpose(0, 2, 1)
        covariance += within.reshape(covariance.shape)
        return mean, 0.5 * (covariance + covariance.transpose(0, 2, 1))

    def _columns(self, columns: Sequence[int], name: str) -> list[int]:
        chosen = [check.integer(c, name, at_least=0, at_most=self.size - 1) for c in columns]
        if not chosen or len(set(chosen)) != len(chosen):
            raise InvalidInput(f"{name}: expected different columns, got {list(columns)}")
        return chosen

    @cached_property
    def _whitening(self) -> Float64Array:
        """Inverses of the lower roots of the covariances, (k, d, d)."""
        try:
            return np.asarray(np.linalg.inv(np.linalg.cholesky(self.covariances)))
        except np.linalg.LinAlgError:
            raise InvalidInput("covariances: expected positive definite matrices") from None

    def _joint(self, data: Float64Array) -> Float64Array:
        return _log_joint(self.weights, self.means, self._whitening, data)


def _log_joint(
    weights: Float64Array, means: Float64Array, whitening: Float64Array, data: Float64Array
) -> Float64Array:
    """Logarithms (n, k) of weight times density at points (n, d)."""
    offsets = data[None] - means[:, None]
    squared = ((offsets @ whitening.transpose(0, 2, 1)) ** 2).sum(axis=2)
    volumes = np.log(np.einsum("kii->ki", whitening)).sum(axis=1)
    with np.errstate(divide="ignore"):  # a component without weight has none anywhere
        constants = np.log(weights) + volumes - 0.5 * means.shape[1] * np.log(2.0 * np.pi)
    return np.asarray(constants - 0.5 * squared.T)


def _log_sum(values: Float64Array) -> Float64Array:
    """log sum exp over the last axis, (n,)."""
    largest = values.max(axis=1)
    return np.asarray(largest + np.log(np.exp(values - largest[:, None]).sum(axis=1)))
