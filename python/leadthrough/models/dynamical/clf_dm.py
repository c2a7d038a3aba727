"""CLF-DM: any regression of velocities, corrected online by a learned Lyapunov function.

Three steps: a control Lyapunov function V, the weighted sum of asymmetric quadratic functions, is
learned so that it falls along the demonstrations; velocities f(x) are regressed, here by Gaussian
mixture regression; and x' = f(x) + u*(x) with the least u* for which V falls,

    u* = 0 where grad V . f <= -rho |grad V|,
    u* = -(grad V . f + rho |grad V|) / |grad V|^2 grad V elsewhere.

Source: Khansari-Zadeh and Billard 2014, "Learning control Lyapunov function to ensure stability of
dynamical system-based robot reaching motions", Robotics and Autonomous Systems 62, 752-765. Ours,
as it leaves them open: rho(x) = rho_0 (1 - exp(-|x| / 0.05)) is a speed, as it is multiplied by
|grad V|; V is learned from twelve starts, with bounded parameters; what the regression gives at the
goal, where the velocity has to be 0, is taken off within a twentieth of the motion's size; and four
deviations and more away from all demonstrations, f gives way to -3 x.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.models.dynamical import lyapunov
from leadthrough.models.dynamical.linear_mixture import GaussianGates, velocity_mixture
from leadthrough.models.dynamical.model import DynamicalModel, Samples

_NEAR = 0.05  # sizes of the motion
# Deviation, in sizes of the motion, that samples count for where they agree better.
_MIN_WIDTH = 0.03


@dataclass(frozen=True, eq=False)
class MixtureRegression(ShortRepr):
    """Gaussian mixture regression: x' = sum_k h_k(x) (A_k x + b_k)."""

    gates: GaussianGates  # the mixture of positions
    gains: Float64Array  # A_k, (k, d, d)
    constants: Float64Array  # b_k, (k, d)

    @property
    def size(self) -> int:
        return int(self.constants.shape[1])

    def velocity(self, x: Float64Array) -> Float64Array:
        k, d, _ = self.gains.shape
        each = (x @ self.gains.reshape(k * d, d).T).reshape(len(x), k, d) + self.constants
        return np.asarray((self.gates.weights(x)[:, :, None] * each).sum(axis=1))

    def trust(self, x: Float64Array) -> Float64Array:
        return lyapunov.trusted(np.exp(-0.5 * self._wide.squared(x)))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        return {"gains": self.gains, "constants": self.constants, **self.gates.arrays()}

    @staticmethod
    def from_arrays(arrays: Mapping[str, NDArray[Any]]) -> MixtureRegression:
        gates = GaussianGates.from_arrays(arrays)
        return MixtureRegression(gates, arrays["gains"], arrays["constants"])

    @cached_property
    def _wide(self) -> GaussianGates:
        """The gates, each widened by the least width."""
        whitening = self.gates.whitening
        spread = np.linalg.inv(np.einsum("kij,kil->kjl", whitening, whitening))
        wide = spread + _MIN_WIDTH**2 * np.eye(self.size)
        return GaussianGates.of(np.exp(self.gates.logits), self.gates.means, wide)


@dataclass(frozen=True, eq=False)
class CorrectedMixture(lyapunov.Corrected):
    """A mixture's regression, corrected so that a sum of asymmetric quadratics decreases."""

    regressions: ClassVar[Any] = MixtureRegression
    energies: ClassVar[Any] = lyapunov.AsymmetricQuadratics


@dataclass(frozen=True)
class CLFDM(DynamicalModel):
    """Gaussian mixture regression of velocities, made stable by a learned Lyapunov function.

    Attributes:
        components: number of components of the regression, 1 to 50.
        quadratics: number of asymmetric quadratic functions of the Lyapunov function, 0 to 20.
        slowest: least speed down the Lyapunov function, in sizes of the motion per duration, > 0.
        seed: seed of the random number generator that draws all starts, >= 0.
    """

    components: int = 8
    quadratics: int = 3
    slowest: float = 0.1
    seed: int = 0

    system = CorrectedMixture
    slider = ("components", 1, 20)

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=50)
        check.integer(self.quadratics, "quadratics", at_least=0, at_most=20)
        check.number(self.slowest, "slowest", above=0.0)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> CorrectedMixture:
        x, v = samples.x, samples.v
        energy = lyapunov.fitted_quadratics(x, v, self.quadratics, seed=self.seed)
        regression = mixture_regression(x, v, self.components, seed=self.seed)
        return CorrectedMixture(regression, energy, lyapunov.Descent(self.slowest, _NEAR))


def mixture_regression(
    x: Float64Array, v: Float64Array, components: int, *, seed: int
) -> MixtureRegression:
    """The regression by the most likely mixture of positions x and velocities v (n, d)."""
    d = x.shape[1]
    mixture, spread, gains = velocity_mixture(x, v, components, seed=seed)
    positions, velocities = mixture.means[:, :d], mixture.means[:, d:]
    constants = velocities - np.einsum("kij,kj->ki", gains, positions)
    return MixtureRegression(GaussianGates.of(mixture.weights, positions, spread), gains, constants)
