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

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from leadthrough import check
from leadthrough.models.dynamical.gates import SigmoidGates
from leadthrough.models.dynamical.linear_mixture import LinearMixture
from leadthrough.models.dynamical.model import DynamicalModel
from leadthrough.models.dynamical.regression import random_units
from leadthrough.models.dynamical.samples import Shown
from leadthrough.models.dynamical.semidefinite import stable_matrices

_DECAY, _RIDGE = 0.1, 1e-5
_STEEP = 6.0  # of the sigmoids, per unit of the motion's size


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

    slider: ClassVar[tuple[str, int, int]] = ("units", 1, 60)

    def __post_init__(self) -> None:
        check.integer(self.units, "units", at_least=1, at_most=200)
        check.integer(self.seed, "seed", at_least=0)

    def _learned(self, shown: Shown) -> LinearMixture:
        x, v = shown.x, shown.v
        gates = SigmoidGates(*random_units(x, self.units, seed=self.seed, steep=_STEEP))
        metric = np.eye(x.shape[1])
        weights = gates.weights(x)
        found = stable_matrices(weights, x, v, metric=metric, decay=_DECAY, ridge=_RIDGE)
        return LinearMixture(gates, found, metric)
