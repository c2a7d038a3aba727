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

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy import sparse
from scipy.optimize import nnls

from leadthrough import check, optional
from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models.dynamical.gates import squared_distances
from leadthrough.models.dynamical.kernel_potential import KernelPotential, kernels
from leadthrough.models.dynamical.model import DynamicalModel
from leadthrough.models.dynamical.samples import Shown
from leadthrough.models.dynamical.semidefinite import EXTRA, solved
from leadthrough.models.gaussians.kmeans import clustered, seeds

# Mean damping, per duration: a mass then takes a thirtieth of it to follow the force.
_DAMPING = 30.0
_LEAST_DAMPING = 6.0
_RIDGE, _RIDGE_OF_DAMPING = 1e-4, 1e-3
# Width of the kernels, in mean distances of a centre from its nearest.
_WIDTH = 1.2
# x . grad V >= this times |x|^2 times the mean damping.
_SLOPE = 0.15
# Forces count by their directions, those below this fraction of the mean one less.
_WEAK = 0.2
_SAMPLES, _CHECKED, _ROUNDS = 800, 4_000, 8
_REACH = 4.0  # sizes of the motion, up to which samples lie


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

    slider: ClassVar[tuple[str, int, int]] = ("kernels", 5, 80)

    def __post_init__(self) -> None:
        check.integer(self.kernels, "kernels", at_least=2, at_most=200)
        check.integer(self.seed, "seed", at_least=0)

    def _learned(self, shown: Shown) -> KernelPotential:
        x, v = shown.x, shown.v
        rng = np.random.default_rng(self.seed)
        inner = clustered(x, seeds(x, min(self.kernels - 1, len(x)), rng)).centres
        centres = np.concatenate([np.zeros((1, x.shape[1])), inner])
        between = squared_distances(centres, centres) + 1e9 * np.eye(len(centres))
        width = _WIDTH * float(np.sqrt(between.min(axis=1)).mean())
        pairs = zip(shown.positions, shown.velocities, strict=True)
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
    clarabel = optional.load("clarabel", extra=EXTRA)
    size = len(normal)
    stiff = np.eye(size)[size // 2 :]
    every = sparse.csc_matrix(np.vstack([at_goal, -rows, -stiff]))
    bounds = np.concatenate([np.zeros(len(at_goal)), -least, np.zeros(len(stiff))])
    cones = [
        clarabel.ZeroConeT(len(at_goal)),
        clarabel.NonnegativeConeT(len(rows) + len(stiff)),
    ]
    quadratic = sparse.triu(sparse.csc_matrix(normal), format="csc")
    return solved(quadratic, linear, every, bounds, cones)


def _features(centres: Float64Array, width: float, x: Float64Array) -> Float64Array:
    """What turns heights and stiffnesses (2 k,) into gradients of the potential, (n, d, 2 k)."""
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
    need = (-undamped.gradient(x) - bent).ravel() - rows @ np.full(count, _LEAST_DAMPING)
    ridge = np.sqrt(_RIDGE_OF_DAMPING * len(x)) * np.eye(count)
    usual = ridge @ np.full(count, _DAMPING - _LEAST_DAMPING)
    more, _ = nnls(np.vstack([rows, ridge]), np.concatenate([need, usual]))
    return np.asarray(_LEAST_DAMPING + more)
