"""A network as an energy: V(x) = |x|^2 exp(2 h(x)), h(x) = sum_i c_i tanh(w_i . x + b_i), c_i >= 0.

With t_i = w_i . x, x . grad V = 2 V (1 + sum_i c_i t_i sech^2(t_i + b_i)). As -t sech^2(t + b) is
below k(b) = 0.1 + 0.75 log(1 + exp(2 b)) for all t, sum_i c_i k(b_i) < 1 makes V grow along every
ray; the 0.1 also bounds h.
Its level sets are stars about the goal, convex or not, as the demonstrations need them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from leadthrough.check import Float64Array
from leadthrough.models.dynamical import lyapunov
from leadthrough.repr import ShortRepr

# Of the bound of sum_i c_i k(b_i), which is 1.
_MOST_SLOPE = 0.95
# Of k(b): the second alone would do for stability.
_FLOOR, _BOUND = 0.1, 0.75
_SPREAD = 2.0  # deviation of the first directions, per unit of the motion's size
_FIRST = 0.3  # roots of the first heights, before they are bounded
_STARTS = 4
_TINY = 1e-9


@dataclass(frozen=True, eq=False)
class StarNetwork(ShortRepr):
    """An energy whose level sets are stars."""

    directions: Float64Array  # w_i, (m, d)
    offsets: Float64Array  # b_i, (m,)
    heights: Float64Array  # c_i, (m,), >= 0

    def value(self, x: Float64Array) -> Float64Array:
        """Energies (n,) at positions (n, d)."""
        raised = np.tanh(x @ self.directions.T + self.offsets) @ self.heights
        return np.asarray((x**2).sum(axis=1) * np.exp(2.0 * raised))

    def gradient(self, x: Float64Array) -> Float64Array:
        """Their gradients (n, d)."""
        tanh = np.tanh(x @ self.directions.T + self.offsets)
        scale = np.exp(2.0 * tanh @ self.heights)[:, None]
        bent = ((1.0 - tanh**2) * self.heights) @ self.directions
        return np.asarray(2.0 * scale * (x + (x**2).sum(axis=1)[:, None] * bent))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        return {name: getattr(self, name) for name in ("directions", "offsets", "heights")}


def fitted(x: Float64Array, v: Float64Array, count: int, *, seed: int) -> StarNetwork:
    """The network that falls best along demonstrations."""
    d = x.shape[1]
    used = (np.linalg.norm(v, axis=1) > 0.0) & (np.linalg.norm(x, axis=1) > _TINY)
    rng = np.random.default_rng(seed)
    starts = []
    for _ in range(_STARTS):
        directions = _SPREAD * rng.standard_normal((count, d))
        offsets = -(directions * x[rng.integers(len(x), size=count)]).sum(axis=1)
        starts.append(np.concatenate([directions.ravel(), offsets, np.full(count, _FIRST)]))
    found = lyapunov.fitted(lambda p, at: _gradient(p, at, count), starts, x[used], v[used])
    return _built(found, d, count)


def _built(packed: Float64Array, d: int, count: int) -> StarNetwork:
    directions = packed[: count * d].reshape(count, d)
    offsets, free = packed[count * d :].reshape(2, count)
    total = 1.0 + slope_bounds(offsets) @ free**2
    return StarNetwork(directions, offsets, _MOST_SLOPE * free**2 / total)


def slope_bounds(offsets: Float64Array) -> Float64Array:
    """k(b) (m,), which -t sech^2(t + b) stays below for every t."""
    return np.asarray(_FLOOR + _BOUND * np.logaddexp(0.0, 2.0 * offsets))


def _gradient(
    packed: Float64Array, x: Float64Array, count: int
) -> tuple[Float64Array, lyapunov.Slopes]:
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
        share = _MOST_SLOPE / (1.0 + bounds @ free**2)
        spill = (in_heights @ free**2) * share**2 / _MOST_SLOPE
        in_free = 2.0 * free * (in_heights * share - spill * bounds)
        steep = 2.0 * _BOUND * expit(2.0 * b)
        in_offsets = bent.sum(axis=0) - spill * steep * free**2
        return np.concatenate([in_directions.ravel(), in_offsets, in_free])

    return gradient, back
