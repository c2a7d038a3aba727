"""Energies learned from demonstrations, which fall along them, and the correction of velocities.

Every energy here grows along every ray from the goal, x . grad V(x) > 0, so that its gradient
vanishes nowhere else: a system that descends it everywhere ends at the goal.

Source: Khansari-Zadeh and Billard 2014, "Learning control Lyapunov function to ensure stability of
dynamical system-based robot reaching motions", Robotics and Autonomous Systems 62, 752-765.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.field import Field, StoredArrays

# Weight of falling faster beside not rising: it decides where nothing rises.
_EAGERNESS = 1e-2
# Every start is followed for some iterations, and the best ones to the end.
_TRIAL_ITERATIONS, _MAX_ITERATIONS, _FOLLOWED = 60, 300, 2
_SAMPLES = 250  # at most
_TINY = 1e-12
# The least eigenvalues of P_0 and of the symmetric parts of P_l, and the largest entries of the
# roots of P_0 and P_l, of the skew parts and the centres. Without them, valleys of the energy
# become so narrow that a trajectory follows them in tiny steps only.
_MIN_EIGENVALUES = (0.05, 0.1)
_STARTS = 12
_MAX_ENTRIES = (1.0, 0.7, 0.7, 1.5)
# Distance from the goal within which the regression's velocity at the goal is subtracted.
_AT_GOAL = 0.05
# Far from all demonstrations, the velocity is -x times this, per duration, before it is corrected.
_HOME = 3.0
# Deviations from the nearest samples at which a regression is trusted by half.
_TRUSTED = 4.0


class Energy(Protocol):
    """A function that grows along every ray from the goal, where it is 0."""

    def value(self, x: Float64Array) -> Float64Array:
        """Energies (n,) at positions (n, d)."""

    def gradient(self, x: Float64Array) -> Float64Array:
        """Their gradients (n, d)."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""


# From the parameters and positions x (n, d): gradients of the energy (n, d), and the function that
# turns slopes (n, d) in these into slopes in the parameters.
Slopes = Callable[[Float64Array], Float64Array]
Learned = Callable[[Float64Array, Float64Array], tuple[Float64Array, Slopes]]


def fitted_energy(
    gradient: Learned,
    starts: list[Float64Array],
    x: Float64Array,
    v: Float64Array,
    *,
    largest: Float64Array | None = None,
) -> Float64Array:
    """The parameters with which an energy falls best along demonstrations."""
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
    ended = [run(each.x, _MAX_ITERATIONS) for each in begun[:_FOLLOWED]]
    return np.asarray(min(ended, key=lambda each: each.fun).x)


@dataclass(frozen=True)
class Descent:
    """The correction of a velocity that makes an energy fall."""

    slowest: float  # least speed downhill far from the goal, in normalised units, > 0
    near: float  # distance from the goal, > 0, below which it falls to 0

    def corrected(
        self, velocity: Float64Array, x: Float64Array, uphill: Float64Array
    ) -> Float64Array:
        """The nearest velocities (n, d) that descend an energy."""
        # Khansari-Zadeh and Billard 2014, whose rho we multiply by |grad V|: it is then a speed.
        length = np.linalg.norm(uphill, axis=1, keepdims=True)
        direction = uphill / np.maximum(length, _TINY)
        distance = np.linalg.norm(x, axis=1, keepdims=True)
        least = self.slowest * -np.expm1(-distance / self.near)
        excess = (velocity * direction).sum(axis=1, keepdims=True) + least
        return np.asarray(velocity - np.maximum(excess, 0.0) * direction)


@dataclass(frozen=True, eq=False)
class AsymmetricQuadratics(StoredArrays):
    """A weighted sum of asymmetric quadratic functions (WSAQF).

    V(x) = x^T P_0 x + sum_l max(0, q_l)^2, q_l = x^T P_l (x - c_l), all P_l + P_l^T > 0. As
    x . grad V = 2 x^T P_0 x + sum_l 2 q_l (q_l + x^T P_l x) > 0 where q_l > 0, it grows along rays.

    Source: Khansari-Zadeh and Billard 2014, eqs. 5 and 6.
    """

    symmetric: Float64Array  # P_0, (d, d)
    matrices: Float64Array  # P_l, (l, d, d)
    centres: Float64Array  # c_l, (l, d)

    def value(self, x: Float64Array) -> Float64Array:
        active = self._terms(x)[0]
        return np.asarray((x @ self.symmetric * x).sum(axis=1) + (active**2).sum(axis=0))

    def gradient(self, x: Float64Array) -> Float64Array:
        active, along = self._terms(x)
        return np.asarray(2.0 * (x @ self.symmetric + (active[:, :, None] * along).sum(axis=0)))

    def _terms(self, x: Float64Array) -> tuple[Float64Array, Float64Array]:
        """max(0, q_l), (l, n), and the gradients (l, n, d) of q_l."""
        forward = (x[None] - self.centres[:, None]) @ self.matrices.transpose(0, 2, 1)
        active = np.maximum((forward * x).sum(axis=2), 0.0)
        return active, forward + x @ self.matrices


def fitted_quadratics(
    x: Float64Array, v: Float64Array, count: int, *, seed: int
) -> AsymmetricQuadratics:
    """The sum of asymmetric quadratic functions that falls best along demonstrations."""
    size = x.shape[1]
    moving = np.linalg.norm(v, axis=1) > 0.0
    rng = np.random.default_rng(seed)
    starts = [_start(x, count, rng) for _ in range(_STARTS if count else 1)]
    sizes = [size**2, count * size**2, count * size**2, count * size]
    bounds = np.repeat(_MAX_ENTRIES, sizes)
    parameters = fitted_energy(
        lambda p, at: _gradient(p, at, count), starts, x[moving], v[moving], largest=bounds
    )
    return _built(parameters, size, count)


def _start(x: Float64Array, count: int, rng: np.random.Generator) -> Float64Array:
    """Parameters of round functions about samples drawn at random."""
    size = x.shape[1]
    centres = x[rng.integers(len(x), size=count)]
    tilted = np.eye(size) + 0.1 * rng.standard_normal((count, size, size))
    parts = [np.eye(size), tilted, np.zeros((count, size, size)), centres]
    return np.concatenate([part.ravel() for part in parts])


def _split(packed: Float64Array, d: int, count: int) -> tuple[Float64Array, ...]:
    """The roots of P_0 (d, d) and of P_l (l, d, d), their skew parts and the centres (l, d)."""
    sizes = np.cumsum([d * d, count * d * d, count * d * d])
    root, roots, skew, centres = np.split(packed, sizes)
    shape = (count, d, d)
    return root.reshape(d, d), roots.reshape(shape), skew.reshape(shape), centres.reshape(count, d)


def _built(packed: Float64Array, d: int, count: int) -> AsymmetricQuadratics:
    root, roots, skew, centres = _split(packed, d, count)
    matrices = (
        roots @ roots.transpose(0, 2, 1)
        + skew
        - skew.transpose(0, 2, 1)
        + _MIN_EIGENVALUES[1] * np.eye(d)
    )
    symmetric = root @ root.T + _MIN_EIGENVALUES[0] * np.eye(d)
    return AsymmetricQuadratics(symmetric, matrices, centres)


def _gradient(packed: Float64Array, x: Float64Array, count: int) -> tuple[Float64Array, Slopes]:
    d = x.shape[1]
    root, roots, _, _ = _split(packed, d, count)
    built = _built(packed, d, count)
    active, along = built._terms(x)

    def back(pull: Float64Array) -> Float64Array:
        """The slopes in the parameters, of slopes (n, d) in the gradient of the energy."""
        plain = 2.0 * pull.T @ x
        counts = active > 0.0
        on_active = np.where(counts, (along * pull).sum(axis=2), 0.0)[:, :, None]
        q = active[:, :, None]
        off = x[None] - built.centres[:, None]
        # q has the slope x (x - c)^T in P, its gradient's product with the pull p has
        # p (x - c)^T + x p^T; in c they are -P^T x and -P^T p.
        at_x = (on_active * x).transpose(0, 2, 1)
        at_pull = (q * pull).transpose(0, 2, 1)
        in_matrix = 2.0 * (at_x @ off + at_pull @ off + (q * x).transpose(0, 2, 1) @ pull)
        moved = (on_active * x + q * pull).sum(axis=1)
        in_centre = -2.0 * (moved[:, None, :] @ built.matrices)[:, 0]
        transposed = in_matrix.transpose(0, 2, 1)
        parts = [
            (plain + plain.T) @ root,
            (in_matrix + transposed) @ roots,
            in_matrix - transposed,
            in_centre,
        ]
        return np.concatenate([part.ravel() for part in parts])

    return built.gradient(x), back


class Regression(Protocol):
    """Velocities at positions."""

    @property
    def size(self) -> int:
        """Number d of columns."""

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""

    def trust(self, x: Float64Array) -> Float64Array:
        """Trust (n,) at positions (n, d): 1 at demonstrations, falling to 0 away from them."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""


@dataclass(frozen=True, eq=False)
class Corrected(Field):
    """x' = f(x) + u(x): a regression f, and the least u with which the energy falls."""

    regression: Regression
    potential: Energy  # the energy
    descent: Descent  # least speed down the energy

    name: ClassVar[str] = "corrected"
    regressions: ClassVar[Any]  # class of the regression
    energies: ClassVar[Any]  # class of the energy

    @property
    def size(self) -> int:
        return self.regression.size

    def velocity(self, x: Float64Array) -> Float64Array:
        fading = np.exp(-0.5 * ((x / _AT_GOAL) ** 2).sum(axis=1, keepdims=True))
        trust = self.regression.trust(x)[:, None]
        velocity = trust * (self.regression.velocity(x) - fading * self._rest)
        velocity -= _HOME * (1.0 - trust) * x
        return self.descent.corrected(velocity, x, self.potential.gradient(x))

    def energy(self, states: Float64Array) -> Float64Array:
        return self.potential.value(states)

    def power(self, states: Float64Array) -> Float64Array:
        uphill = self.potential.gradient(states)
        return np.asarray((uphill * self.velocity(states)).sum(axis=1))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        descent = np.array([self.descent.slowest, self.descent.near])
        return {"descent": descent, **self.regression.arrays(), **self.potential.arrays()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        return cls(
            cls.regressions.from_arrays(arrays),
            cls.energies.from_arrays(arrays),
            Descent(*map(float, arrays["descent"])),
        )

    @cached_property
    def _rest(self) -> Float64Array:
        return self.regression.velocity(np.zeros((1, self.regression.size)))


def trusted(nearness: Float64Array) -> Float64Array:
    """1 where one of exp(-d_i^2 / 2), (n, k), is large, 1/2 where d = 4, 0 beyond: (n,)."""
    near = nearness.sum(axis=1)
    return np.asarray(near / (near + np.exp(-0.5 * _TRUSTED**2)))
