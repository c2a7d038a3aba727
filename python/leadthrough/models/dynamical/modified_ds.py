"""Modified DS: a network's velocities, corrected by a Lyapunov function that is a network too.

The velocities f(x) of the original system are a network's; V is a neural function with a single
minimum, learned so that it falls along the demonstrations; the modified system is f(x) + u(x) with
the least u for which V falls.

Source: Zhang, Cheng, Li and Cao 2022, "Learning accurate and stable point-to-point motions: a
dynamic system approach", IEEE Robotics and Automation Letters 7, 1510-1517 (reference 29 of Prados
et al. 2023). We know it by its summary, not by its formulas. So these are ours: V(x) = |x|^2
exp(2 h(x)) with a network h whose slope along rays is bounded (`StarNetwork`), the hidden units of
f at random samples with ridge regression behind them, and the correction, which is CLF-DM's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.special import expit

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.models.dynamical.field import StoredArrays, squared_distances
from leadthrough.models.dynamical.lyapunov import Corrected, Descent, Slopes, fitted_energy, trusted
from leadthrough.models.dynamical.model import DynamicalModel, Samples

_NEAR = 0.05  # sizes of the motion
_RIDGE, _WIDTH = 1e-5, 0.1
# Of the bound of sum_i c_i k(b_i), which is 1.
_MAX_SLOPE = 0.95
# Of k(b): the second alone would do for stability.
_FLOOR, _BOUND = 0.1, 0.75
_SPREAD = 2.0  # deviation of the first directions, per unit of the motion's size
_FIRST_ROOT = 0.3  # roots of the first heights, before they are bounded
_STARTS = 4
_AT_GOAL = 1e-9


@dataclass(frozen=True, eq=False)
class NetworkRegression(StoredArrays):
    """A network with one hidden layer of Gaussians: x' = sum_i exp(-|x - c_i|^2 / (2 s^2)) g_i."""

    hidden: Float64Array  # c_i, (m, d)
    width: Float64Array  # s, (1,)
    outer: Float64Array  # g_i, (m, d)

    @property
    def size(self) -> int:
        return int(self.outer.shape[1])

    def velocity(self, x: Float64Array) -> Float64Array:
        return np.asarray(self._units(x) @ self.outer)

    def trust(self, x: Float64Array) -> Float64Array:
        return trusted(self._units(x))

    def _units(self, x: Float64Array) -> Float64Array:
        return np.asarray(np.exp(-0.5 * squared_distances(x, self.hidden) / self.width[0] ** 2))


@dataclass(frozen=True, eq=False)
class StarNetwork(StoredArrays):
    """An energy V(x) = |x|^2 exp(2 h(x)), h(x) = sum_i c_i tanh(w_i . x + b_i), c_i >= 0.

    With t_i = w_i . x, x . grad V = 2 V (1 + sum_i c_i t_i sech^2(t_i + b_i)). As -t sech^2(t + b)
    is below k(b) = 0.1 + 0.75 log(1 + exp(2 b)) for all t, sum_i c_i k(b_i) < 1 makes V grow along
    every ray; the 0.1 also bounds h. Its level sets are stars about the goal, convex or not.
    """

    directions: Float64Array  # w_i, (m, d)
    offsets: Float64Array  # b_i, (m,)
    heights: Float64Array  # c_i, (m,), >= 0

    def value(self, x: Float64Array) -> Float64Array:
        raised = np.tanh(x @ self.directions.T + self.offsets) @ self.heights
        return np.asarray((x**2).sum(axis=1) * np.exp(2.0 * raised))

    def gradient(self, x: Float64Array) -> Float64Array:
        tanh = np.tanh(x @ self.directions.T + self.offsets)
        scale = np.exp(2.0 * tanh @ self.heights)[:, None]
        bent = ((1.0 - tanh**2) * self.heights) @ self.directions
        return np.asarray(2.0 * scale * (x + (x**2).sum(axis=1)[:, None] * bent))


@dataclass(frozen=True, eq=False)
class CorrectedNetwork(Corrected):
    """A network's regression, corrected so that a star-shaped energy decreases."""

    regressions: ClassVar[Any] = NetworkRegression
    energies: ClassVar[Any] = StarNetwork


@dataclass(frozen=True)
class ModifiedDS(DynamicalModel):
    """A network of velocities, made stable by a neural Lyapunov function.

    Attributes:
        units: number of hidden units of the velocities' network, 1 to 1000.
        energy_units: number of hidden units of the Lyapunov function, 1 to 200.
        slowest: least speed down the Lyapunov function, in sizes of the motion per duration, > 0.
        seed: seed of the random number generator that draws the hidden units, >= 0.
    """

    units: int = 100
    energy_units: int = 20
    slowest: float = 0.1
    seed: int = 0

    system = CorrectedNetwork
    slider = ("units", 10, 300)

    def __post_init__(self) -> None:
        check.integer(self.units, "units", at_least=1, at_most=1000)
        check.integer(self.energy_units, "energy_units", at_least=1, at_most=200)
        check.number(self.slowest, "slowest", above=0.0)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> CorrectedNetwork:
        x, v = samples.x, samples.v
        energy = fitted_network(x, v, self.energy_units, seed=self.seed)
        regression = network_regression(
            x, v, self.units, width=_WIDTH, ridge=_RIDGE, seed=self.seed
        )
        return CorrectedNetwork(regression, energy, Descent(self.slowest, _NEAR))


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


def fitted_network(x: Float64Array, v: Float64Array, count: int, *, seed: int) -> StarNetwork:
    """The network that falls best along demonstrations."""
    d = x.shape[1]
    used = (np.linalg.norm(v, axis=1) > 0.0) & (np.linalg.norm(x, axis=1) > _AT_GOAL)
    rng = np.random.default_rng(seed)
    starts = []
    for _ in range(_STARTS):
        directions = _SPREAD * rng.standard_normal((count, d))
        offsets = -(directions * x[rng.integers(len(x), size=count)]).sum(axis=1)
        starts.append(np.concatenate([directions.ravel(), offsets, np.full(count, _FIRST_ROOT)]))
    parameters = fitted_energy(lambda p, at: _gradient(p, at, count), starts, x[used], v[used])
    return _built(parameters, d, count)


def _built(packed: Float64Array, d: int, count: int) -> StarNetwork:
    directions = packed[: count * d].reshape(count, d)
    offsets, free = packed[count * d :].reshape(2, count)
    total = 1.0 + slope_bounds(offsets) @ free**2
    return StarNetwork(directions, offsets, _MAX_SLOPE * free**2 / total)


def slope_bounds(offsets: Float64Array) -> Float64Array:
    """k(b) (m,), which -t sech^2(t + b) stays below for every t."""
    return np.asarray(_FLOOR + _BOUND * np.logaddexp(0.0, 2.0 * offsets))


def _gradient(packed: Float64Array, x: Float64Array, count: int) -> tuple[Float64Array, Slopes]:
    """grad V / (2 V), of the same direction, and its slopes."""
    d = x.shape[1]
    free = packed[count * d + count :]
    built = _built(packed, d, count)
    w, b, c = built.directions, built.offsets, built.heights
    tanh = np.tanh(x @ w.T + b)
    bell = 1.0 - tanh**2
    gradient = x / (x**2).sum(axis=1)[:, None] + (bell * c) @ w

    def back(pull: Float64Array) -> Float64Array:
        along = pull @ w.T
        bent = -2.0 * tanh * bell * along * c
        in_heights = (bell * along).sum(axis=0)
        in_directions = (bell * c).T @ pull + bent.T @ x
        # c_i = most free_i^2 / (1 + sum_j k(b_j) free_j^2)
        bounds = slope_bounds(b)
        share = _MAX_SLOPE / (1.0 + bounds @ free**2)
        spill = (in_heights @ free**2) * share**2 / _MAX_SLOPE
        in_free = 2.0 * free * (in_heights * share - spill * bounds)
        steep = 2.0 * _BOUND * expit(2.0 * b)
        in_offsets = bent.sum(axis=0) - spill * steep * free**2
        return np.concatenate([in_directions.ravel(), in_offsets, in_free])

    return gradient, back
