"""Energies learned from demonstrations, which fall along them, and the correction of velocities.

Every energy here grows along every ray from the goal, x . grad V(x) > 0, so that its gradient
vanishes nowhere else: whatever descends it everywhere ends at the goal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from leadthrough.check import Float64Array

# Weight of falling faster beside not rising: it decides where nothing rises.
_EAGERNESS = 1e-2
# Every start is followed for some iterations, and the best ones to the end.
_TRIAL_ITERATIONS, _MOST_ITERATIONS, _FOLLOWED = 60, 300, 2
_SAMPLES = 250  # that are looked at, at most
_TINY = 1e-12


class Energy(Protocol):
    """A function that grows along every ray from the goal, where it is 0."""

    def value(self, x: Float64Array) -> Float64Array:
        """Energies (n,) at positions (n, d)."""

    def gradient(self, x: Float64Array) -> Float64Array:
        """Their gradients (n, d)."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""


# From the parameters and positions x (n, d): gradients of the energy (n, d), and what turns a
# function's slopes (n, d) in these into its slopes in the parameters.
Slopes = Callable[[Float64Array], Float64Array]
Learned = Callable[[Float64Array, Float64Array], tuple[Float64Array, Slopes]]


def fitted(
    gradient: Learned,
    starts: list[Float64Array],
    x: Float64Array,
    v: Float64Array,
    *,
    largest: Float64Array | None = None,
) -> Float64Array:
    """The parameters with which an energy falls best along demonstrations.

    Source: Khansari-Zadeh and Billard 2014, the objective of the learning of Lyapunov functions.
    """
    every = -(-len(x) // _SAMPLES)
    x, v = x[::every], v[::every]
    unit = v / np.linalg.norm(v, axis=1, keepdims=True)

    def objective(parameters: Float64Array) -> tuple[float, Float64Array]:
        slope, back = gradient(parameters, x)
        length = np.linalg.norm(slope, axis=1, keepdims=True) + _TINY
        uphill = slope / length
        cosine = (uphill * unit).sum(axis=1)
        weight = np.where(cosine > 0.0, 1.0, -_EAGERNESS) / len(x)
        pull = 2.0 * (weight * cosine)[:, None] * (unit - cosine[:, None] * uphill) / length
        return float((weight * cosine**2).sum()), back(pull)

    bounds = None if largest is None else np.stack([-largest, largest], axis=1)

    def run(start: Float64Array, iterations: int) -> OptimizeResult:
        options = {"maxiter": iterations, "ftol": 1e-10, "gtol": 1e-8, "maxcor": 20}
        return minimize(
            objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options
        )

    begun = sorted((run(each, _TRIAL_ITERATIONS) for each in starts), key=lambda each: each.fun)
    ended = [run(each.x, _MOST_ITERATIONS) for each in begun[:_FOLLOWED]]
    return np.asarray(min(ended, key=lambda each: each.fun).x)


@dataclass(frozen=True)
class Descent:
    """How a velocity is corrected so that an energy falls."""

    slowest: float  # least speed downhill far from the goal, in normalised units, > 0
    near: float  # distance from the goal, > 0, below which less is asked for

    def corrected(
        self, velocity: Float64Array, x: Float64Array, uphill: Float64Array
    ) -> Float64Array:
        """The velocities (n, d) nearest to those given that descend an energy.

        Source: Khansari-Zadeh and Billard 2014, whose rho we multiply by |grad V|: it is then a
        speed, and does not depend on the energy's scale.
        """
        length = np.linalg.norm(uphill, axis=1, keepdims=True)
        direction = uphill / np.maximum(length, _TINY)
        distance = np.linalg.norm(x, axis=1, keepdims=True)
        least = self.slowest * -np.expm1(-distance / self.near)
        excess = (velocity * direction).sum(axis=1, keepdims=True) + least
        return np.asarray(velocity - np.maximum(excess, 0.0) * direction)
