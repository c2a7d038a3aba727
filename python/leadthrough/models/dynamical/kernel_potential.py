"""A potential of local bowls, and a damping that varies with the place: the field of UMIC.

With normalised kernels k_i(x) ~ exp(-|x - c_i|^2 / (2 s^2)), the potential is
V(x) = sum_i k_i(x) (a_i + b_i |x - c_i|^2 / 2) - V_0 and the damping D(x) = sum_i k_i(x) d_i > 0:

    x'' = -grad V(x) - D(x) x'.

The energy |x'|^2 / 2 + V(x) falls with D |x'|^2.
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
from leadthrough.models.dynamical.gates import squared_distances


@dataclass(frozen=True, eq=False)
class KernelPotential(Field):
    """A unit mass in a potential with damping."""

    centres: Float64Array  # c_i, (k, d)
    width: Float64Array  # s of the kernels, (1,)
    heights: Float64Array  # a_i, (k,)
    stiffness: Float64Array  # b_i, (k,)
    damping: Float64Array  # d_i, (k,)

    name: ClassVar[str] = "kernel_potential"

    @property
    def size(self) -> int:
        """Number d of columns."""
        return int(self.centres.shape[1])

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at which the damping balances the potential's force."""
        weights = self._weights(x)
        return -self.gradient(x, weights) / (weights @ self.damping)[:, None]

    def states(self, x: Float64Array) -> Float64Array:
        """The positions (n, d), moving as the policy says."""
        return np.hstack([x, self.velocity(x)])

    def rate(self, states: Float64Array) -> Float64Array:
        """Derivatives (n, 2 d) of positions and velocities."""
        x, v = np.split(states, 2, axis=1)
        weights = self._weights(x)
        resisted = (weights @ self.damping)[:, None] * v
        return np.hstack([v, -self.gradient(x, weights) - resisted])

    def energy(self, states: Float64Array) -> Float64Array:
        """Kinetic and potential energies (n,) of states (n, 2 d)."""
        x, v = np.split(states, 2, axis=1)
        return np.asarray(0.5 * (v**2).sum(axis=1) + self._potential(x) - self._lowest)

    def power(self, states: Float64Array) -> Float64Array:
        """Derivatives (n,) of the energy of states (n, 2 d)."""
        x, v = np.split(states, 2, axis=1)
        return np.asarray(-(self._weights(x) @ self.damping) * (v**2).sum(axis=1))

    def gradient(self, x: Float64Array, weights: Float64Array | None = None) -> Float64Array:
        """Gradients (n, d) of the potential at positions (n, d)."""
        weights = self._weights(x) if weights is None else weights
        bowls = self.heights + 0.5 * self.stiffness * self._squared(x)
        off = weights * (bowls - (weights * bowls).sum(axis=1, keepdims=True))
        pulled = weights * self.stiffness
        plain = x * pulled.sum(axis=1, keepdims=True) - pulled @ self.centres
        return np.asarray(plain + off @ self.centres / self.width[0] ** 2)

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        names = ("centres", "width", "heights", "stiffness", "damping")
        return {name: getattr(self, name) for name in names}

    @staticmethod
    def from_arrays(arrays: Mapping[str, NDArray[Any]]) -> KernelPotential:
        """The field that `arrays` took apart."""
        names = ("centres", "width", "heights", "stiffness", "damping")
        return KernelPotential(*(arrays[name] for name in names))

    def _potential(self, x: Float64Array) -> Float64Array:
        bowls = self.heights + 0.5 * self.stiffness * self._squared(x)
        return np.asarray((self._weights(x) * bowls).sum(axis=1))

    @cached_property
    def _lowest(self) -> float:
        """V_0, the potential at the goal."""
        return float(self._potential(np.zeros((1, self.size)))[0])

    def _squared(self, x: Float64Array) -> Float64Array:
        return squared_distances(x, self.centres)

    def _weights(self, x: Float64Array) -> Float64Array:
        return kernels(x, self.centres, float(self.width[0]))


def kernels(x: Float64Array, centres: Float64Array, width: float) -> Float64Array:
    """Normalised kernels (n, k) of positions (n, d)."""
    raised = -0.5 * squared_distances(x, centres) / width**2
    raised -= raised.max(axis=1, keepdims=True)
    np.exp(raised, out=raised)
    raised /= raised.sum(axis=1, keepdims=True)
    return raised
