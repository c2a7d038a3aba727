"""Velocities regressed on positions, without any promise of stability: what is corrected later."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.gates import GaussianGates, squared_distances
from leadthrough.models.dynamical.linear_mixture import vars_of
from leadthrough.models.gaussians.fitting import fit_mixture
from leadthrough.repr import ShortRepr

# Deviation of random directions' entries, per unit of the motion's size.
_STEEP = 3.0
# Deviations from the nearest samples at which a regression is trusted by half.
_TRUSTED = 4.0
# Deviation, in sizes of the motion, that samples count for where they agree better.
_LEAST_WIDTH = 0.03


class Regression(Protocol):
    """Velocities at positions."""

    @property
    def size(self) -> int:
        """Number d of columns."""

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""

    def trust(self, x: Float64Array) -> Float64Array:
        """1 where demonstrations were, falling to 0 away from them: (n,) at positions (n, d)."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""


@dataclass(frozen=True, eq=False)
class MixtureRegression(ShortRepr):
    """Gaussian mixture regression: x' = sum_k h_k(x) (A_k x + b_k)."""

    gates: GaussianGates  # the mixture of positions
    gains: Float64Array  # A_k, (k, d, d)
    constants: Float64Array  # b_k, (k, d)

    @property
    def size(self) -> int:
        """Number d of columns."""
        return int(self.constants.shape[1])

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""
        k, d, _ = self.gains.shape
        each = (x @ self.gains.reshape(k * d, d).T).reshape(len(x), k, d) + self.constants
        return np.asarray((self.gates.weights(x)[:, :, None] * each).sum(axis=1))

    def trust(self, x: Float64Array) -> Float64Array:
        """1 where demonstrations were, falling to 0 away from them: (n,) at positions (n, d)."""
        return trusted(np.exp(-0.5 * self._wide.squared(x)))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        return {"gains": self.gains, "constants": self.constants, **vars_of(self.gates)}

    @cached_property
    def _wide(self) -> GaussianGates:
        """The gates, each widened by the least width."""
        whitening = self.gates.whitening
        spread = np.linalg.inv(np.einsum("kij,kil->kjl", whitening, whitening))
        wide = spread + _LEAST_WIDTH**2 * np.eye(self.size)
        return GaussianGates.of(np.exp(self.gates.logits), self.gates.means, wide)


def mixture_regression(
    x: Float64Array, v: Float64Array, components: int, *, seed: int
) -> MixtureRegression:
    """The regression by the most likely mixture of positions x and velocities v (n, d)."""
    d = x.shape[1]
    mixture = fit_mixture(np.hstack([x, v]), components, seed=seed, starts=1).mixture
    spread, cross = mixture.covariances[:, :d, :d], mixture.covariances[:, d:, :d]
    solved = np.linalg.solve(spread, cross.transpose(0, 2, 1))
    gains = np.asarray(solved).transpose(0, 2, 1)
    places, speeds = mixture.means[:, :d], mixture.means[:, d:]
    constants = speeds - np.einsum("kij,kj->ki", gains, places)
    return MixtureRegression(GaussianGates.of(mixture.weights, places, spread), gains, constants)


@dataclass(frozen=True, eq=False)
class NetworkRegression(ShortRepr):
    """A network with one hidden layer of Gaussians: x' = sum_i exp(-|x - c_i|^2 / (2 s^2)) g_i."""

    hidden: Float64Array  # c_i, (m, d)
    width: Float64Array  # s, (1,)
    outer: Float64Array  # g_i, (m, d)

    @property
    def size(self) -> int:
        """Number d of columns."""
        return int(self.outer.shape[1])

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""
        return np.asarray(self._units(x) @ self.outer)

    def trust(self, x: Float64Array) -> Float64Array:
        """1 where demonstrations were, falling to 0 away from them: (n,) at positions (n, d)."""
        return trusted(self._units(x))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        return {name: getattr(self, name) for name in ("hidden", "width", "outer")}

    def _units(self, x: Float64Array) -> Float64Array:
        return np.asarray(np.exp(-0.5 * squared_distances(x, self.hidden) / self.width[0] ** 2))


def network_regression(
    x: Float64Array, v: Float64Array, units: int, *, width: float, ridge: float, seed: int
) -> NetworkRegression:
    """The network with hidden units at random samples and outer weights by ridge regression."""
    rng = np.random.default_rng(seed)
    hidden = x[rng.choice(len(x), min(units, len(x)), replace=False)]
    empty = NetworkRegression(hidden, np.array([width]), np.zeros((len(hidden), x.shape[1])))
    layer = empty._units(x)
    normal = layer.T @ layer + ridge * len(x) * np.eye(len(hidden))
    return replace(empty, outer=np.asarray(np.linalg.solve(normal, layer.T @ v)))


def trusted(nearness: Float64Array) -> Float64Array:
    """1 where one of exp(-d_i^2 / 2), (n, k), is large, 1/2 where d = 4, 0 beyond: (n,)."""
    near = nearness.sum(axis=1)
    return np.asarray(near / (near + np.exp(-0.5 * _TRUSTED**2)))


def random_units(
    x: Float64Array, units: int, *, seed: int, steep: float = _STEEP
) -> tuple[Float64Array, Float64Array]:
    """Directions (m, d) and offsets (m,) of hidden units that bend at samples drawn at random."""
    rng = np.random.default_rng(seed)
    inner = steep * rng.standard_normal((units, x.shape[1]))
    bends = x[rng.integers(len(x), size=units)]
    return inner, -(inner * bends).sum(axis=1)
