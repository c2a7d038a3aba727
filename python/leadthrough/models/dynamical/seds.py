"""SEDS: a Gaussian mixture regression whose every component is stable.

x' = sum_k h_k(x) A_k x with the posteriors h_k of a mixture of positions. The constraints
b_k = -A_k x* (the components pass through the goal x* = 0) and A_k + A_k^T < 0 make |x|^2 fall
everywhere: (|x|^2)' = sum_k h_k x^T (A_k + A_k^T) x < 0.

Source: Khansari-Zadeh and Billard 2011, "Learning stable nonlinear dynamical systems with Gaussian
mixture models", IEEE Transactions on Robotics 27, 943-957. The paper solves its programme with
constraints by interior points; here the constraints hold by the choice of the parameters, and
L-BFGS solves what is left. What it leaves open and is ours: the samples near rest that are left
out, the least deviation of a component (0.02 of the motion's size) and the slowest decay.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from leadthrough import check
from leadthrough.models.dynamical import stable_gmr
from leadthrough.models.dynamical.gates import GaussianGates
from leadthrough.models.dynamical.linear_mixture import LinearMixture
from leadthrough.models.dynamical.model import DynamicalModel
from leadthrough.models.dynamical.samples import Shown
from leadthrough.models.dynamical.stable_gmr import StableGMR
from leadthrough.models.gaussians.fitting import fit_mixture

OBJECTIVES = ("likelihood", "mse")


@dataclass(frozen=True)
class SEDS(DynamicalModel):
    """The stable estimator of dynamical systems, for points, joints or poses.

    The distance from the goal never grows along its motions: demonstrations that go away from the
    goal are cut short.

    Attributes:
        components: number of components, 1 to 50.
        objective: "likelihood" of positions and velocities, or "mse", the mean squared error of the
            velocities.
        seed: seed of the random number generator that draws the starts of EM, >= 0.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    components: int = 6
    objective: Literal["likelihood", "mse"] = "likelihood"
    seed: int = 0

    slider: ClassVar[tuple[str, int, int]] = ("components", 1, 15)

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=50)
        check.choice(self.objective, "objective", OBJECTIVES)
        check.integer(self.seed, "seed", at_least=0)

    def _learned(self, shown: Shown) -> LinearMixture:
        start = first_guess(shown, self.components, seed=self.seed)
        likely = self.objective == "likelihood"
        solve = stable_gmr.most_likely if likely else stable_gmr.least_squares
        found = solve(start, shown.x, shown.v)
        return LinearMixture(found.gates, found.matrices, np.eye(shown.x.shape[1]))


def first_guess(shown: Shown, components: int, *, seed: int) -> StableGMR:
    """The most likely mixture of positions and velocities, each component made stable."""
    x, v = shown.x, shown.v
    d = x.shape[1]
    mixture = fit_mixture(np.hstack([x, v]), components, seed=seed, starts=1).mixture
    spread, cross = mixture.covariances[:, :d, :d], mixture.covariances[:, d:, :d]
    gains = np.linalg.solve(spread, cross.transpose(0, 2, 1)).transpose(0, 2, 1)
    matrices = stable_gmr.stable(np.asarray(gains))
    residuals = v[None] - x @ matrices.transpose(0, 2, 1)
    shares = mixture.responsibilities(np.hstack([x, v])).T
    scatter = (shares[:, :, None] * residuals).transpose(0, 2, 1) @ residuals
    noise = scatter / np.maximum(shares.sum(axis=1), 1e-9)[:, None, None] + 1e-2 * np.eye(d)
    gates = GaussianGates.of(mixture.weights, mixture.means[:, :d], spread + 1e-3 * np.eye(d))
    return StableGMR(gates, matrices, np.linalg.inv(np.linalg.cholesky(noise)))
