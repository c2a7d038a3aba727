"""UMIC: a potential and a dissipative field, found by two convex programmes.

The motion is that of a unit mass, x'' = -grad V(x) - D(x) x'. The first programme fits the
potential's force to the forces that the demonstrations need, with V growing along rays from the
goal, so that it has no other minimum; the second the damping, so that the velocities are those of
the demonstrations.

Source: Khansari-Zadeh and Khatib 2017, "Learning potential functions from human demonstrations with
encapsulated dynamic and compliant behaviors", Autonomous Robots 41, 45-69. We know its form,
kernels that mix bowls and dampers, and two quadratic programmes, but not its constraints. So these
are ours: the centres by k-means, one width of the kernels, the mean damping, and x . grad V > 0 at
samples that are added until 4,000 further ones agree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import nnls

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models import kmeans
from leadthrough.models.dynamical.field import Field, squared_distances
from leadthrough.models.dynamical.linear_mixture import solve_cone_programme
from leadthrough.models.dynamical.model import DynamicalModel, Samples

# Mean damping, per duration: a mass then takes a thirtieth of it to follow the force.
_DAMPING = 30.0
_MIN_DAMPING = 6.0
_RIDGE, _RIDGE_OF_DAMPING = 1e-4, 1e-3
# Deviation of a push's velocity in the test of stability, in sizes of the motion per duration.
_PUSH = 2.0
# Width of the kernels, in mean distances of a centre from its nearest.
_WIDTH = 1.2
# x . grad V >= this times |x|^2 times the mean damping.
_SLOPE = 0.15
# Forces count by their directions, those below this fraction of the mean one less.
_WEAK = 0.2
_SAMPLES, _CHECKED, _ROUNDS = 800, 4_000, 8
_REACH = 4.0  # sizes of the motion, up to which samples lie


@dataclass(frozen=True, eq=False)
class KernelPotential(Field):
    """A unit mass in a potential of local bowls, x'' = -grad V(x) - D(x) x'.

    With kernels k_i(x) ~ exp(-|x - c_i|^2 / (2 s^2)) that sum to 1, V(x) = sum_i k_i(x)
    (a_i + b_i |x - c_i|^2 / 2) - V_0 and D(x) = sum_i k_i(x) d_i > 0. The energy |x'|^2 / 2 + V(x)
    falls with D |x'|^2.
    """

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

    def pushed_states(self, x: Float64Array, rng: np.random.Generator) -> Float64Array:
        """The positions (n, d) with the policy's velocity and that of a push."""
        return self.states(x) + np.hstack([0.0 * x, _PUSH * rng.standard_normal(x.shape)])

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
        """Its arrays, by the names of its attributes."""
        names = ("centres", "width", "heights", "stiffness", "damping")
        return {name: getattr(self, name) for name in names}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The system with these arrays."""
        names = ("centres", "width", "heights", "stiffness", "damping")
        return cls(*(arrays[name] for name in names))

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


@dataclass(frozen=True)
class UMIC(DynamicalModel):
    """Unified motion and impedance: a mass in a learned potential; needs the extra `stable`.

    Its `policy` is the velocity at which the damping balances the force.

    Attributes:
        kernels: number of kernels, 2 to 200.
        seed: seed of the random number generator that draws centres and samples, >= 0.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    kernels: int = 50
    seed: int = 0

    system: ClassVar[type[Field]] = KernelPotential
    slider: ClassVar[tuple[str, int, int]] = ("kernels", 5, 80)

    def __post_init__(self) -> None:
        check.integer(self.kernels, "kernels", at_least=2, at_most=200)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> KernelPotential:
        """The system of normalised demonstrations."""
        x, v = samples.x, samples.v
        rng = np.random.default_rng(self.seed)
        inner = kmeans(x, min(self.kernels - 1, len(x)), seed=rng).centres
        centres = np.concatenate([np.zeros((1, x.shape[1])), inner])
        between = squared_distances(centres, centres) + 1e9 * np.eye(len(centres))
        width = _WIDTH * float(np.sqrt(between.min(axis=1)).mean())
        pairs = zip(samples.positions, samples.velocities, strict=True)
        bent = np.concatenate([_accelerations(*each) for each in pairs])
        heights, stiffness = _potential(centres, width, x, v + bent / _DAMPING, rng)
        undamped = KernelPotential(
            centres,
            np.array([width]),
            _DAMPING * heights,
            _DAMPING * stiffness,
            np.zeros(len(centres)),
        )
        return replace(undamped, damping=_damping(undamped, x, v, bent))


def _accelerations(x: Float64Array, v: Float64Array) -> Float64Array:
    """v dv/dx (n, d) along the samples of a demonstration: their steps in time are not needed."""
    lengths = np.linalg.norm(np.diff(x, axis=0), axis=1)
    speeds = np.linalg.norm(0.5 * (v[1:] + v[:-1]), axis=1)
    steps = lengths / np.maximum(speeds, 1e-6) + 1e-6
    times = np.concatenate([[0.0], np.cumsum(steps)])
    return np.gradient(v, times, axis=0) if len(x) > 1 else np.zeros_like(v)


def _potential(
    centres: Float64Array,
    width: float,
    x: Float64Array,
    force: Float64Array,
    rng: np.random.Generator,
) -> tuple[Float64Array, Float64Array]:
    """Heights and stiffnesses (k,) whose downhill forces are nearest to those wanted (n, d)."""
    features = _features(centres, width, x)
    size = features.shape[2]
    strength = np.linalg.norm(force, axis=1)
    weight = 1.0 / (strength + _WEAK * strength.mean())
    flat = (weight[:, None, None] * features).reshape(-1, size)
    normal = flat.T @ flat / len(x) + _RIDGE * np.eye(size)
    linear = flat.T @ (weight[:, None] * force).ravel() / len(x)
    at_goal = _features(centres, width, np.zeros((1, x.shape[1])))[0]
    bounded = _samples(x, _SAMPLES, rng)
    for _ in range(_ROUNDS):
        found = _programme(normal, linear, at_goal, *_radial(centres, width, bounded))
        fresh = _samples(x, _CHECKED, rng)
        rows, least = _radial(centres, width, fresh)
        wrong = rows @ found < 0.2 * least
        if not wrong.any():
            return found[: len(centres)], found[len(centres) :]
        bounded = np.concatenate([bounded, fresh[wrong]])
    raise FitError(
        "demonstrations: no potential without other minima was found; use fewer kernels or CLFDM"
    )


def _programme(
    normal: Float64Array,
    linear: Float64Array,
    at_goal: Float64Array,
    rows: Float64Array,
    least: Float64Array,
) -> Float64Array:
    """The quadratic programme: rows of the first group are equal to 0, those of the others >=."""
    clarabel = check.package("clarabel", extra="stable")
    size = len(normal)
    stiff = np.eye(size)[size // 2 :]
    every = sparse.csc_matrix(np.vstack([at_goal, -rows, -stiff]))
    bounds = np.concatenate([np.zeros(len(at_goal)), -least, np.zeros(len(stiff))])
    cones = [
        clarabel.ZeroConeT(len(at_goal)),
        clarabel.NonnegativeConeT(len(rows) + len(stiff)),
    ]
    quadratic = sparse.triu(sparse.csc_matrix(normal), format="csc")
    return solve_cone_programme(quadratic, linear, every, bounds, cones)


def _features(centres: Float64Array, width: float, x: Float64Array) -> Float64Array:
    """Linear map (n, d, 2 k) of heights and stiffnesses (2 k,) to gradients of the potential."""
    weights = kernels(x, centres, width)
    half = 0.5 * squared_distances(x, centres)
    spread = (centres[None] - (weights @ centres)[:, None]) / width**2  # (n, k, d)
    slopes = weights[:, :, None] * spread
    bowls = half[:, :, None] * slopes + weights[:, :, None] * (x[:, None] - centres[None])
    return np.concatenate([slopes, bowls], axis=1).transpose(0, 2, 1)


def _radial(
    centres: Float64Array, width: float, x: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Rows (n, 2 k) and bounds (n,) of x . grad V >= slope |x|^2, over |x|^2."""
    rows = np.einsum("ndk,nd->nk", _features(centres, width, x), x)
    squared = (x**2).sum(axis=1)
    return rows / squared[:, None], np.full(len(x), _SLOPE)


def _samples(x: Float64Array, count: int, rng: np.random.Generator) -> Float64Array:
    """Positions (count, d): about the demonstrations, and at all scales about the goal."""
    half = count // 2
    size = x.shape[1]
    about = x[rng.integers(len(x), size=half)]
    near = about + 0.2 * rng.standard_normal(about.shape)
    directions = rng.standard_normal((count - half, size))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    radii = np.exp(rng.uniform(np.log(1e-3), np.log(_REACH), (count - half, 1)))
    return np.concatenate([near, radii * directions])


def _damping(
    undamped: KernelPotential, x: Float64Array, v: Float64Array, bent: Float64Array
) -> Float64Array:
    """Dampings (k,) with which the potential's force moves as the demonstrations do."""
    count = len(undamped.centres)
    weights = kernels(x, undamped.centres, float(undamped.width[0]))
    rows = (weights[:, None, :] * v[:, :, None]).reshape(-1, count)
    need = (-undamped.gradient(x) - bent).ravel() - rows @ np.full(count, _MIN_DAMPING)
    ridge = np.sqrt(_RIDGE_OF_DAMPING * len(x)) * np.eye(count)
    usual = ridge @ np.full(count, _DAMPING - _MIN_DAMPING)
    more, _ = nnls(np.vstack([rows, ridge]), np.concatenate([need, usual]))
    return np.asarray(_MIN_DAMPING + more)


def kernels(x: Float64Array, centres: Float64Array, width: float) -> Float64Array:
    """Normalised kernels (n, k) of positions (n, d)."""
    raised = -0.5 * squared_distances(x, centres) / width**2
    raised -= raised.max(axis=1, keepdims=True)
    np.exp(raised, out=raised)
    raised /= raised.sum(axis=1, keepdims=True)
    return raised
