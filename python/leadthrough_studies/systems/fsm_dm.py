"""FSM-DM: an extreme learning machine whose output weights keep it stable.

x' = A_0 x + sum_i s(w_i . x + b_i) A_i x with sigmoids s of random directions w_i: the hidden layer
is drawn, and the outer weights are found by one convex programme, least squares with A_i + A_i^T
negative definite. As all sigmoids are positive, |x|^2 falls everywhere.

Source: Duan, Ou, Hu, Wang, Jin and Xu 2019, "Fast and stable learning of dynamical systems based on
extreme learning machine", IEEE Transactions on Systems, Man, and Cybernetics: Systems 49,
1175-1185. We know it by its summary: a hidden layer that is drawn, outer weights under constraints
from the Lyapunov function |x|^2 / 2. That outer weights multiply the state, so that the constraints
hold for every x and not only at samples, is ours, as are the number of hidden units and the ridge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.linear_mixture import LinearMixture, stable_matrices
from leadthrough.models.dynamical.model import DynamicalModel, Samples

_DECAY, _RIDGE = 0.1, 1e-5
_STEEP = 6.0  # of the sigmoids, per unit of the motion's size


@dataclass(frozen=True, eq=False)
class SigmoidGates:
    """A constant 1 and m sigmoids of random directions: the hidden layer of a network."""

    directions: Float64Array  # rows (m, d) of the hidden layer's matrix
    offsets: Float64Array  # offsets (m,) of the hidden layer

    @staticmethod
    def drawn(x: Float64Array, units: int, *, seed: int) -> SigmoidGates:
        """Random directions; the sigmoids bend at samples drawn from positions (n, d)."""
        rng = np.random.default_rng(seed)
        directions = _STEEP * rng.standard_normal((units, x.shape[1]))
        bends = x[rng.integers(len(x), size=units)]
        return SigmoidGates(directions, -(directions * bends).sum(axis=1))

    def weights(self, x: Float64Array) -> Float64Array:
        """Weights (n, 1 + m) at positions (n, d)."""
        raised = x @ self.directions.T + self.offsets
        return np.hstack([np.ones((len(x), 1)), 0.5 + 0.5 * np.tanh(0.5 * raised)])

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""
        return {"directions": self.directions, "offsets": self.offsets}


class SigmoidMixture(LinearMixture):
    """Linear systems mixed by sigmoids."""

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The system with these arrays."""
        gates = SigmoidGates(arrays["directions"], arrays["offsets"])
        return cls(gates, arrays["matrices"], arrays["metric"])


@dataclass(frozen=True)
class FSMDM(DynamicalModel):
    """A stable extreme learning machine, for points, joints or poses; needs the extra `stable`.

    The distance from the goal never grows along its motions.

    Attributes:
        units: number of hidden units, 1 to 200.
        seed: seed of the random number generator that draws the hidden layer, >= 0.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    units: int = 25
    seed: int = 0

    system: ClassVar[type[Field]] = SigmoidMixture
    slider: ClassVar[tuple[str, int, int]] = ("units", 1, 60)

    def __post_init__(self) -> None:
        check.integer(self.units, "units", at_least=1, at_most=200)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> SigmoidMixture:
        """The system of normalised demonstrations."""
        x, v = samples.x, samples.v
        gates = SigmoidGates.drawn(x, self.units, seed=self.seed)
        metric = np.eye(x.shape[1])
        weights = gates.weights(x)
        matrices = stable_matrices(weights, x, v, metric=metric, decay=_DECAY, ridge=_RIDGE)
        return SigmoidMixture(gates, matrices, metric)
