"""Normal distributions of a vector: conditioned on linear observations, multiplied."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.promp.dense import product as matrix_product
from leadthrough.models.promp.dense import root_of
from leadthrough.repr import ShortRepr

# Standard deviations below this fraction of the scale of what is observed count as zero: no
# observation moves the distribution in such a direction.
CERTAIN = 1e-7
# An observation may differ by this fraction of the scale, in a direction without variance.
_CONTRADICTION = 1e-6


@dataclass(frozen=True, eq=False)
class Gaussian(ShortRepr):
    """A normal distribution of a vector."""

    mean: Float64Array  # mean (n,)
    covariance: Float64Array  # covariance (n, n), positive semi-definite

    @cached_property
    def root(self) -> Float64Array:
        """A matrix R (n, n) with R @ R.T equal to the covariance."""
        values, vectors = np.linalg.eigh(self.covariance)
        rounding = len(values) * np.finfo(np.float64).eps * values[-1]
        return np.asarray(vectors * np.sqrt(np.where(values > rounding, values, 0.0)))

    @cached_property
    def steady_root(self) -> Float64Array:
        """Another such matrix R, the same whatever the number of threads."""
        return root_of(self.covariance)

    @cached_property
    def certain(self) -> Float64Array:
        """An orthonormal basis (n, m) of the directions that do not vary."""
        values, vectors = np.linalg.eigh(self.covariance)
        return np.asarray(vectors[:, values <= CERTAIN**2 * values[-1]])

    def columns_at(self, rows: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Mean (m, d) and covariance (m, d, d) of columns whose weights are a vector (d k,)."""
        count = rows.shape[1]
        size = len(self.mean) // count
        blocks = self.covariance.reshape(size, count, size, count).transpose(1, 3, 0, 2)
        pairs = (rows[:, :, None] * rows[:, None, :]).reshape(len(rows), -1)
        covariance = matrix_product(pairs, blocks.reshape(count**2, size**2))
        return rows @ self.mean.reshape(size, count).T, covariance.reshape(-1, size, size)

    def draw(self, count: int, rng: np.random.Generator) -> Float64Array:
        """Random vectors (count, n)."""
        normal = rng.standard_normal((count, len(self.mean)))
        return self.mean + matrix_product(normal, self.steady_root.T)

    def observe(
        self,
        rows: Float64Array,
        value: Float64Array,
        noise: Float64Array | None,
        *,
        scale: Float64Array,
        name: str,
    ) -> Gaussian:
        """The distribution of x after observing rows @ x."""
        spread = rows @ self.covariance
        innovation = spread @ rows.T
        if noise is not None:
            innovation = innovation + noise
        units = 1.0 / scale
        variances, axes = np.linalg.eigh(innovation * units * units[:, None])
        surprise = (value - rows @ self.mean) * units
        if variances[0] <= CERTAIN**2:
            uncertain = variances > CERTAIN**2
            variances, axes = variances[uncertain], axes[:, uncertain]
            _refuse_contradiction(surprise - axes @ (axes.T @ surprise), name)
        whitened = (axes / np.sqrt(variances)).T * units
        step = whitened @ spread
        mean = self.mean + ((whitened * scale) @ surprise) @ step
        return Gaussian(mean, self.covariance - step.T @ step)


def product(factors: Sequence[Gaussian], powers: Sequence[float]) -> Gaussian:
    """The normalised product of densities, each raised to a power."""
    result, *others = (
        Gaussian(each.mean, each.covariance / power)
        for each, power in zip(factors, powers, strict=True)
    )
    for other in others:
        total = result.covariance + other.covariance
        gain = result.covariance @ np.linalg.pinv(total, hermitian=True)
        covariance = result.covariance - gain @ result.covariance
        result = Gaussian(
            result.mean + gain @ (other.mean - result.mean), 0.5 * (covariance + covariance.T)
        )
    return result


def _refuse_contradiction(missed: Float64Array, name: str) -> None:
    """Refuses an observation that misses what is fixed by fractions (p,) of its scale."""
    farthest = np.abs(missed).max()
    if farthest > _CONTRADICTION:
        raise InvalidInput(
            f"{name}: expected a value that agrees with the points fixed before, got one that "
            f"misses them by {farthest:.3g} times the motion's extent"
        )
