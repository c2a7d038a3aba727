"""The rest of a motion from its first samples, under a t distribution of its weights.

Given the factor of the t distribution's covariance, all is normal; the factor itself, one number,
is integrated over a grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.belief import Belief
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.repr import ShortRepr

# Logarithms of the factors that the covariance is tried with.
_FACTORS = np.linspace(-3.0, 5.5, 86)
# Directions of which the samples tell less than this, relative to what is told most, are unseen.
_UNSEEN = 1e-12


@dataclass(frozen=True, eq=False)
class Forecast(ShortRepr):
    """What is expected of the weights of a motion that has been seen in part."""

    weights: Gaussian  # mean and covariance of the weights (d k,)
    freedom: float  # degrees of freedom, > 4, of the t distribution with these moments


class Seen:
    """Samples of a motion at supposed phases, under a belief about its weights."""

    def __init__(
        self,
        belief: Belief,
        basis: Basis,
        phases: Float64Array,
        values: Float64Array,
        noise: Float64Array,
    ) -> None:
        self._belief = belief
        size, rows, root = len(noise), basis(phases), belief.spread.root
        residual = (values - rows @ belief.spread.mean.reshape(size, -1).T) / np.sqrt(noise)
        # Few functions reach far into the part that was seen: as few rows tell as much.
        across, lengths, along = np.linalg.svd(rows, full_matrices=False)
        told = lengths > 1e-9 * lengths[0]
        few = lengths[told, None] * along[told]
        blocks = root.reshape(size, basis.count, -1) / np.sqrt(noise)[:, None, None]
        self._reached = np.matmul(few, blocks).reshape(-1, root.shape[1])
        # In the coordinates z, weights = mean + root reached.T axes z, each is told on its own.
        precisions, axes = np.linalg.eigh(self._reached @ self._reached.T)
        seen = precisions > _UNSEEN * precisions[-1]
        self._precisions, self._axes = precisions[seen], axes[:, seen]
        pulled = self._axes.T @ (across[:, told].T @ residual).T.ravel()
        self._pulled = pulled * np.sqrt(self._precisions)
        self._factors, believed = _believed(belief.freedom)
        # Variance (factors, z) of each z after the samples.
        self._variances = 1.0 / (1.0 / self._factors[:, None] + self._precisions)
        gained = self._variances @ self._pulled**2
        volume = np.log1p(self._factors[:, None] * self._precisions).sum(axis=1)
        scores = believed + 0.5 * (gained - volume)
        likely = np.exp(scores - scores.max())
        constant = (residual**2).sum() + len(values) * np.log(2.0 * np.pi * noise).sum()
        self.evidence = float(scores.max() + np.log(likely.sum()) - 0.5 * constant)
        self._likely = likely / likely.sum()

    def forecast(self) -> Forecast:
        """The distribution of the weights, its first two moments those of the mixture."""
        factor = float(self._likely @ self._factors)
        gain = self._likely @ self._variances
        varied = (self._variances - gain) * self._pulled
        root = self._belief.spread.root
        seen = root @ (self._reached.T @ (self._axes / np.sqrt(self._precisions)))
        within = np.diag(gain - factor) + (varied.T * self._likely) @ varied
        covariance = factor * (root @ root.T) + seen @ within @ seen.T
        mean = self._belief.spread.mean + seen @ (gain * self._pulled)
        return Forecast(Gaussian(mean, 0.5 * (covariance + covariance.T)), self._freedom(factor))

    def _freedom(self, factor: float) -> float:
        """Of the inverse gamma distribution with the factor's mean and variance."""
        variance = float(self._likely @ (self._factors - factor) ** 2)
        return 4.0 + 2.0 * factor**2 / variance if variance > 0.0 else np.inf


@lru_cache(maxsize=64)  # every pace that is tried asks for those of the same skill
def _believed(freedom: float) -> tuple[Float64Array, Float64Array]:
    """Factors (n,) of the covariance, and the logs of their prior probabilities."""
    from scipy.special import logsumexp

    if np.isinf(freedom):
        return np.ones(1), np.zeros(1)
    log_density = -0.5 * freedom * (_FACTORS + np.exp(-_FACTORS) - 1.0)
    return np.exp(_FACTORS), log_density - logsumexp(log_density)
