"""Normal distributions of a vector: observed through linear maps, multiplied, sampled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Standard deviations below this share of the scale of what is observed count as certain: no
# observation moves the distribution in such a direction.
CERTAIN = 1e-7


@dataclass(frozen=True, eq=False)
class Gaussian:
    """mean: (n,). covariance: (n, n), positive semi-definite."""

    mean: Float64Array
    covariance: Float64Array

    @cached_property
    def root(self) -> Float64Array:
        """A matrix (n, n) whose product with its own transpose is the covariance.

        Variances that are rounding are none: what was observed exactly does not move.
        """
        values, vectors = np.linalg.eigh(self.covariance)
        rounding = len(values) * np.finfo(np.float64).eps * values[-1]
        return np.asarray(vectors * np.sqrt(np.where(values > rounding, values, 0.0)))

    def observe(
        self,
        rows: Float64Array,
        value: Float64Array,
        noise: Float64Array | None,
        *,
        scale: Float64Array,
        name: str,
    ) -> Gaussian:
        """The distribution given that rows @ x is a value, within a noise covariance.

        rows: (p, n). value: (p,). noise: (p, p), or None: exactly. scale: (p,) what counts as
        large. Raises InvalidInput, about the argument `name`, where the distribution rules the
        value out.
        """
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


def product(factors: Sequence[Gaussian], shares: Sequence[float]) -> Gaussian:
    """The normalised product of densities to the powers of shares > 0.

    Without inverting a covariance, so that factors may be certain in some directions.
    """
    result, *others = (
        Gaussian(each.mean, each.covariance / share)
        for each, share in zip(factors, shares, strict=True)
    )
    for other in others:
        total = result.covariance + other.covariance
        gain = result.covariance @ np.linalg.pinv(total, hermitian=True)
        covariance = result.covariance - gain @ result.covariance
        result = Gaussian(
            result.mean + gain @ (other.mean - result.mean), 0.5 * (covariance + covariance.T)
        )
    return result


def _refuse_contradiction(left: Float64Array, name: str) -> None:
    if np.abs(left).max() > 1e-6:
        raise InvalidInput(
            f"{name}: expected one that agrees with what was fixed before, got one that is "
            f"{np.abs(left).max():.3g} of the motion's extent away from it"
        )
