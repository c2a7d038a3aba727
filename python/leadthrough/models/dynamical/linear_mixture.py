"""Mixtures of linear systems: x' = sum_k h_k(x) A_k x with weights h_k >= 0 that depend on x.

With one matrix P > 0 for which P A_k + A_k^T P < 0 for all k, V = x^T P x falls along every
trajectory, wherever it starts and whatever the weights are: the goal is globally stable.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.gates import Gates, GaussianGates, SigmoidGates


@dataclass(frozen=True, eq=False)
class LinearMixture(Field):
    """A mixture of linear systems, stable by one quadratic energy."""

    gates: Gates  # the weights h_k
    matrices: Float64Array  # matrices A_k, (k, d, d)
    metric: Float64Array  # matrix P (d, d) of the energy

    name: ClassVar[str] = "linear_mixture"

    @property
    def size(self) -> int:
        """Number d of columns."""
        return len(self.metric)

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""
        each = (x @ self._stacked).reshape(len(x), *self.matrices.shape[:2])
        return np.asarray((self.gates.weights(x)[:, :, None] * each).sum(axis=1))

    def energy(self, states: Float64Array) -> Float64Array:
        """Energies (n,), x^T P x."""
        return np.asarray((states @ self.metric * states).sum(axis=1))

    def power(self, states: Float64Array) -> Float64Array:
        """Derivatives (n,) of the energy at positions (n, d)."""
        return np.asarray(2.0 * (states @ self.metric * self.velocity(states)).sum(axis=1))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        return {"matrices": self.matrices, "metric": self.metric, **vars_of(self.gates)}

    @staticmethod
    def from_arrays(arrays: Mapping[str, NDArray[Any]]) -> LinearMixture:
        """The system that `arrays` took apart."""
        gates: Gates
        if "logits" in arrays:
            gates = GaussianGates(*(arrays[name] for name in ("logits", "means", "whitening")))
        else:
            gates = SigmoidGates(arrays["directions"], arrays["offsets"])
        return LinearMixture(gates, arrays["matrices"], arrays["metric"])

    @cached_property
    def _stacked(self) -> Float64Array:
        """All A_k^T beside each other, (d, k d)."""
        k, d, _ = self.matrices.shape
        return np.ascontiguousarray(self.matrices.reshape(k * d, d).T)


def vars_of(gates: Gates) -> dict[str, NDArray[Any]]:
    """The arrays of gates by the names of their attributes."""
    return {name: value for name, value in vars(gates).items() if not name.startswith("_")}
