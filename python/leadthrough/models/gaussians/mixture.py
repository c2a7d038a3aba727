"""Gaussian mixtures and the regression with them.

Sources: Ghahramani and Jordan 1994, "Supervised learning from incomplete data via an EM approach";
Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval", section 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.repr import ShortRepr

_SUM_TOLERANCE = 1e-6  # of weights that were rounded in a file


@dataclass(frozen=True, eq=False)
class Mixture(ShortRepr):
    """A mixture of k normal distributions of d columns.

    Attributes:
        weights: weights (k,), >= 0, of sum 1.
        means: means (k, d).
        covariances: covariances (k, d, d), positive definite.

    Raises:
        InvalidInput: if the shapes differ, the weights do not sum to 1 or a covariance is not
            positive definite.
    """

    weights: Float64Array
    means: Float64Array
    covariances: Float64Array

    def __init__(self, weights: ArrayLike, means: ArrayLike, covariances: ArrayLike) -> None:
        own_weights = check.frozen(weights, "weights", shape=("k",))
        own_means = check.frozen(means, "means", shape=(len(own_weights), "d"))
        shape = (*own_means.shape, own_means.shape[1])
        own_covariances = check.frozen(covariances, "covariances", shape=shape)
        if not (own_weights >= 0.0).all() or abs(own_weights.sum() - 1.0) > _SUM_TOLERANCE:
            raise InvalidInput(f"weights: expected fractions that sum to 1, got {own_weights}")
        object.__setattr__(self, "weights", own_weights)
        object.__setattr__(self, "means", own_means)
        object.__setattr__(self, "covariances", own_covariances)
        _ = self._whitening  # a covariance that is not positive definite is refused here

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.weights)

    @property
    def size(self) -> int:
        """Number of columns."""
        return int(self.means.shape[1])

    def log_density(self, points: ArrayLike) -> Float64Array:
        """Logarithm of the density at each point.

        Args:
            points: points (n, d).

        Returns:
            Logarithms (n,).
        """
        data = check.array(points, "points", shape=("n", self.size))
        return _log_sum(self._joint(data))

    def responsibilities(self, points: ArrayLike) -> Float64Array:
        """Probability that each point belongs to each component.

        Args:
            points: points (n, d).

        Returns:
            Probabilities (n, k).
        """
        joint = self._joint(check.array(points, "points", shape=("n", self.size)))
        return np.asarray(np.exp(joint - _log_sum(joint)[:, None]))

    def sample(self, count: int, *, seed: int) -> Float64Array:
        """Random points (count, d).

        Args:
            count: number of points, >= 1.
            seed: seed of the random number generator, >= 0.
        """
        size = check.affordable_count(count, "count", each=self.size**2)
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        which = rng.choice(self.count, size, p=self.weights / self.weights.sum())
        normal = rng.standard_normal((size, self.size))
        roots = np.linalg.cholesky(self.covariances)
        return np.asarray(self.means[which] + np.einsum("nij,nj->ni", roots[which], normal))

    def regress(
        self, values: ArrayLike, *, inputs: Sequence[int], outputs: Sequence[int] | None = None
    ) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of some columns, given the values of others.

        The covariance is that of the conditional mixture, by the law of total variance.

        Args:
            values: values (n, m) of the inputs.
            inputs: indices of m columns.
            outputs: indices of p other columns; by default all that are not inputs.

        Returns:
            Mean (n, p) and covariance (n, p, p) of the outputs.
        """
        given = self._columns(inputs, "inputs")
        rest = [column for column in range(self.size) if column not in given]
        chosen = rest if outputs is None else self._columns(outputs, "outputs")
        if not chosen or set(chosen) & set(given):
            raise InvalidInput(
                f"outputs: expected at least one column, none of them an input, got {chosen}"
            )
        x = check.array(values, "values", shape=("n", len(given)))
        return self._conditioned(x, given, chosen)

    def _conditioned(
        self, x: Float64Array, given: list[int], chosen: list[int]
    ) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of the columns `chosen` at values x (n, m) of the columns `given`."""
        of_inputs = self.covariances[:, given][:, :, given]
        whitening = np.linalg.inv(np.linalg.cholesky(of_inputs))
        joint = _log_joint(self.weights, self.means[:, given], whitening, x)
        weights = np.exp(joint - _log_sum(joint)[:, None])  # of the components at each input
        cross = self.covariances[:, chosen][:, :, given]
        gains = cross @ whitening.transpose(0, 2, 1) @ whitening
        inner = self.covariances[:, chosen][:, :, chosen] - gains @ cross.transpose(0, 2, 1)
        offsets = x[None] - self.means[:, None, given]
        means = self.means[:, None, chosen] + offsets @ gains.transpose(0, 2, 1)  # (k, n, p)
        mean = np.einsum("nk,knp->np", weights, means)
        # The spread of the components' means about their mean, free of cancellation.
        apart = (means - mean).transpose(1, 2, 0)
        within = weights @ inner.reshape(self.count, -1)
        covariance = (apart * weights[:, None, :]) @ apart.transpose(0, 2, 1)
        covariance += within.reshape(covariance.shape)
        return mean, 0.5 * (covariance + covariance.transpose(0, 2, 1))

    def _columns(self, columns: Sequence[int], name: str) -> list[int]:
        chosen = [check.integer(c, name, at_least=0, at_most=self.size - 1) for c in columns]
        if not chosen or len(set(chosen)) != len(chosen):
            raise InvalidInput(
                f"{name}: expected at least one column, each once, got {list(columns)}"
            )
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
    """Logarithms (n, k) of each component's weight times its density at points (n, d)."""
    offsets = data[None] - means[:, None]
    squared = ((offsets @ whitening.transpose(0, 2, 1)) ** 2).sum(axis=2)
    volumes = np.log(np.einsum("kii->ki", whitening)).sum(axis=1)
    with np.errstate(divide="ignore"):  # a component without weight has none anywhere
        constants = np.log(weights) + volumes - 0.5 * means.shape[1] * np.log(2.0 * np.pi)
    return np.asarray(constants - 0.5 * squared.T)


def _log_sum(values: Float64Array) -> Float64Array:
    """log sum exp (n,) over the last axis of values (n, k)."""
    largest = values.max(axis=1)
    return np.asarray(largest + np.log(np.exp(values - largest[:, None]).sum(axis=1)))
