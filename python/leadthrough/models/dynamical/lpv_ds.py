"""LPV-DS: a mixture of linear systems with a learned quadratic energy.

x' = sum_k h_k(x) A_k x with the posteriors h_k of a mixture of positions and P A_k + A_k^T P < 0:
the energy x^T P x falls everywhere. In turn, the mixture is fitted so that a component holds
positions near each other with velocities in one direction, P is learned so that the energy falls
along the demonstrations, and the A_k are the least squares of a semidefinite programme.

Source: Figueroa and Billard 2018, "A physically-consistent Bayesian non-parametric mixture model
for dynamical system learning", CoRL, 927-946. Its mixture is drawn by Gibbs sampling from a
distance-dependent process; ours is the most likely one, by EM, of positions and directions of
motion that are independent of each other within a component, with the number of components by the
Bayesian information criterion. P is learned as the quadratic part of CLF-DM's energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough import check
from leadthrough.check import FitError, Float64Array
from leadthrough.models.dynamical.linear_mixture import (
    GaussianGates,
    LinearMixture,
    stable_matrices,
)
from leadthrough.models.dynamical.lyapunov import fitted_quadratics
from leadthrough.models.dynamical.model import DynamicalModel, Samples
from leadthrough.models.gaussians.fitting import least_criterion
from leadthrough.models.gaussians.mixture import Blocks, fit_blocks

_DECAY, _RIDGE = 0.1, 1e-6
# The least deviation of a component, of positions and of directions.
_MIN_VARIANCE = 0.02**2
_MAX_COMPONENTS = 10


@dataclass(frozen=True)
class LPVDS(DynamicalModel):
    """Linear systems mixed by position, for points, joints or poses; needs the extra `stable`.

    Attributes:
        components: number of components, 1 to 50; None for the number from 1 to 10 with the least
            Bayesian information criterion.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
    """

    components: int | None = None
    seed: int = 0

    system = LinearMixture
    slider = ("components", 1, 15)

    def __post_init__(self) -> None:
        if self.components is not None:
            check.integer(self.components, "components", at_least=1, at_most=50)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> LinearMixture:
        x, v = samples.x, samples.v
        blocks = self._mixture(x, v)
        gates = GaussianGates.of(blocks.weights, blocks.means[0], blocks.covariances[0])
        metric = fitted_quadratics(x, v, 0, seed=self.seed).symmetric
        metric = metric * len(metric) / np.trace(metric)
        weights = gates.weights(x)
        matrices = stable_matrices(weights, x, v, metric=metric, decay=_DECAY, ridge=_RIDGE)
        return LinearMixture(gates, matrices, metric)

    def _mixture(self, x: Float64Array, v: Float64Array) -> Blocks:
        directions = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)
        if self.components is not None:
            return self._fitted(x, directions, self.components)[0]
        d = x.shape[1]

        def criterion(fit: tuple[Blocks, float]) -> float:
            blocks, likelihood = fit
            free = len(blocks.weights) * (1 + 2 * d + d * (d + 1)) - 1
            # Neighbouring samples tell little that is new: ten count as one.
            return float(free * np.log(len(x)) - 2.0 * 0.1 * len(x) * likelihood)

        most = min(_MAX_COMPONENTS, len(x))
        return least_criterion(lambda count: self._fitted(x, directions, count), criterion, most)[0]

    def _fitted(
        self, x: Float64Array, directions: Float64Array, count: int
    ) -> tuple[Blocks, float]:
        """The components of positions and directions, and the mean log-likelihood per sample."""
        if count > len(x):
            raise FitError(f"components: expected at most one per sample, {len(x)}, got {count}")
        both = np.hstack([x, directions])
        blocks, history = fit_blocks(
            [x, directions], both, count, seed=self.seed, starts=1, least=_MIN_VARIANCE
        )
        return blocks, history[-1]
