"""A regression of velocities, corrected so that a learned energy falls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.asymmetric_quadratics import AsymmetricQuadratics
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.gates import GaussianGates
from leadthrough.models.dynamical.lyapunov import Descent, Energy
from leadthrough.models.dynamical.regression import (
    MixtureRegression,
    NetworkRegression,
    Regression,
)
from leadthrough.models.dynamical.star_network import StarNetwork

# Distance from the goal within which what the regression has left of a velocity there is taken off.
_AT_GOAL = 0.05
# Where no demonstration was, the velocity is -x times this, per duration, before it is corrected.
_HOME = 3.0


@dataclass(frozen=True, eq=False)
class Corrected(Field):
    """x' = f(x) + u(x): a regression f, and the least u with which the energy falls."""

    regression: Regression
    potential: Energy  # the energy
    descent: Descent  # how fast the energy has to fall

    name: ClassVar[str] = "corrected"

    @property
    def size(self) -> int:
        """Number d of columns."""
        return self.regression.size

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""
        fading = np.exp(-0.5 * ((x / _AT_GOAL) ** 2).sum(axis=1, keepdims=True))
        trust = self.regression.trust(x)[:, None]
        wanted = trust * (self.regression.velocity(x) - fading * self._rest)
        wanted -= _HOME * (1.0 - trust) * x
        return self.descent.corrected(wanted, x, self.potential.gradient(x))

    def energy(self, states: Float64Array) -> Float64Array:
        """Energies (n,) of positions (n, d)."""
        return self.potential.value(states)

    def power(self, states: Float64Array) -> Float64Array:
        """Derivatives (n,) of the energy at positions (n, d)."""
        uphill = self.potential.gradient(states)
        return np.asarray((uphill * self.velocity(states)).sum(axis=1))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        descent = np.array([self.descent.slowest, self.descent.near])
        return {"descent": descent, **self.regression.arrays(), **self.potential.arrays()}

    @staticmethod
    def from_arrays(arrays: Mapping[str, NDArray[Any]]) -> Corrected:
        """The system that `arrays` took apart."""
        regression: Regression
        if "gains" in arrays and "constants" in arrays:
            gates = GaussianGates(*(arrays[name] for name in ("logits", "means", "whitening")))
            regression = MixtureRegression(gates, arrays["gains"], arrays["constants"])
        else:
            regression = NetworkRegression(*(arrays[n] for n in ("hidden", "width", "outer")))
        potential: Energy
        if "symmetric" in arrays:
            names = ("symmetric", "matrices", "centres")
            potential = AsymmetricQuadratics(*(arrays[name] for name in names))
        else:
            potential = StarNetwork(*(arrays[n] for n in ("directions", "offsets", "heights")))
        return Corrected(regression, potential, Descent(*map(float, arrays["descent"])))

    @cached_property
    def _rest(self) -> Float64Array:
        """What the regression gives at the goal, (1, d)."""
        return self.regression.velocity(np.zeros((1, self.regression.size)))
