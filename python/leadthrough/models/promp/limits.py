"""Motions of a ProMP inside limits: the most likely one, and their distribution.

The distribution is the normal one of the weights, cut off where motions leave the limits. The
limits along the phases are walls in the space of the weights. Motions are drawn between them by
exact Hamiltonian Monte Carlo, and mean and covariance are those of many draws with fixed seed. Only
directions that the walls constrain are drawn; in the others the distribution stays normal.

Source: Pakman and Paninski 2014, "Exact Hamiltonian Monte Carlo for truncated multivariate
Gaussians".
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.promp import gaussian
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.gaussian import CERTAIN, Gaussian, product, root_of, solve_definite

_PHASES_PER_WEIGHT = 10
# A motion stays this fraction of its reach inside the limits, so that it also keeps them between
# the phases that are checked.
MARGIN = 1e-3
_MAX_ROUNDS = 30
# The programme's residual is zero where it has no solution; far beyond any standard deviation.
_INFEASIBLE = 1e-7

Bounds = tuple[Float64Array, Float64Array]
# Walls farther than this many standard deviations from the motions are never reached.
_NEAR = 5.0
# Directions that the walls see less than this, relative to the one seen most, are not seen.
_UNSEEN = 1e-9
# Draws before the first that counts; draws for mean and covariance; from one motion to the next.
_FIRST, _MANY, _STRIDE = 30, 2000, 8


def checked(lower: ArrayLike, upper: ArrayLike, width: int) -> Bounds:
    """Limits of `width` columns as read-only arrays."""
    limits = []
    for value, name in ((lower, "lower"), (upper, "upper")):
        limit = check.with_gaps(value, name, shape=(width,)).copy()
        if np.isnan(limit).any():
            raise InvalidInput(f"{name}: expected shape ({width},) without NaN, got {value!r}")
        limit.setflags(write=False)
        limits.append(limit)
    if not (limits[0] < limits[1]).all():
        raise InvalidInput(f"lower: expected less than upper, got {limits[0]} and {limits[1]}")
    return limits[0], limits[1]


def moved_inside(
    weights: Gaussian, basis: Basis, bounds: Bounds, scale: Float64Array
) -> Float64Array:
    """The weights nearest to the mean, in the covariance's metric, that keep the limits."""
    rows = basis(phases_of(basis))
    active: list[tuple[int, int, int]] = []  # sample, column, side
    moved = weights.mean
    for _ in range(_MAX_ROUNDS):
        values = product(rows, moved.reshape(len(scale), -1).T)
        worst = _worst_of_each(np.stack([bounds[0] - values, values - bounds[1]]) / scale)
        if not worst:
            return moved
        active = list(dict.fromkeys([*active, *worst]))
        constraints, limits = zip(
            *(_wall(rows, each, bounds, scale) for each in active), strict=True
        )
        moved = _solved(weights, np.stack(constraints), np.array(limits))
    raise _fixed_outside()


def phases_of(basis: Basis) -> Float64Array:
    return np.linspace(0.0, 1.0, _PHASES_PER_WEIGHT * basis.count + 1)


def _fixed_outside() -> InvalidInput:
    return InvalidInput(
        "limits: expected limits that the motion can keep, but its via points or its narrow "
        "spread hold it outside them; widen the limits"
    )


def _worst_of_each(excess: Float64Array) -> list[tuple[int, int, int]]:
    """The local maxima over the samples of how far each limit (2, n, d) is exceeded."""
    padded = np.pad(excess, ((0, 0), (1, 1), (0, 0)), constant_values=-np.inf)
    peak = (excess >= padded[:, :-2]) & (excess >= padded[:, 2:]) & (excess > 0.0)
    return [(int(i), int(j), int(side)) for side, i, j in np.argwhere(peak)]


def _wall(
    rows: Float64Array, active: tuple[int, int, int], bounds: Bounds, scale: Float64Array
) -> tuple[Float64Array, float]:
    """The row (d k,) of a limit at a sample, and the most that its product may be."""
    sample, column, side = active
    row = np.zeros((len(scale), rows.shape[1]))
    row[column] = rows[sample] * (1.0 if side else -1.0)
    inside = float(bounds[1][column] if side else -bounds[0][column])
    return row.ravel(), inside - MARGIN * float(scale[column])


def _solved(weights: Gaussian, constraints: Float64Array, limits: Float64Array) -> Float64Array:
    """The w of least |w - mean|^2 in the covariance's metric with constraints @ w <= limits."""
    # With w = mean + root z a least distance programme (Lawson and Hanson 1974, chapter 23).
    from scipy.optimize import nnls

    reduced = -product(constraints, weights.steady_root)
    needed = product(constraints, weights.mean[:, None])[:, 0] - limits
    system = np.vstack([reduced.T, needed])
    target = np.zeros(len(system))
    target[-1] = 1.0
    try:
        multipliers, residual = nnls(system, target, maxiter=100 * len(limits))
    except RuntimeError:
        raise _fixed_outside() from None
    left = product(system, multipliers[:, None])[:, 0] - target
    if residual < _INFEASIBLE:
        raise _fixed_outside()
    z = -left[:-1] / left[-1]
    return np.asarray(weights.mean + product(weights.steady_root, z[:, None])[:, 0])


class Truncated:
    """A normal distribution of weights, cut off at limits of the motion."""

    def __init__(self, free: Gaussian, basis: Basis, bounds: Bounds, scale: Float64Array) -> None:
        self._free, self._basis, self._bounds, self._scale = free, basis, bounds, scale
        self._root = free.steady_root
        mode = moved_inside(free, basis, bounds, scale)
        rows, self._room, at_mode = self._near(mode)
        # Deviations are root @ z with z standard normal; the walls see only few directions of z.
        reached = product(rows, self._root)
        self._seen, chosen = gaussian.row_basis(reached, least=_UNSEEN)
        self._walls = product(reached, self._seen.T)
        self._start = _substituted(self._walls[chosen], at_mode[chosen])

    @cached_property
    def moments(self) -> Gaussian:
        """The normal distribution of the weights that has the same mean and covariance."""
        if len(self._seen) == 0:
            return self._free
        drawn = self._drawn(_matched(np.random.default_rng(0), _MANY, len(self._seen)), 1)
        middle = drawn.mean(axis=0)
        apart = drawn - middle
        change = product(apart.T, apart) / _MANY - np.eye(len(middle))
        reach = product(self._root, self._seen.T)
        covariance = product(self._root, self._root.T) + product(product(reach, change), reach.T)
        mean = self._free.mean + product(reach, middle[:, None])[:, 0]
        return Gaussian(mean, 0.5 * (covariance + covariance.T))

    def draw(self, count: int, rng: np.random.Generator) -> Float64Array:
        """Random weights (count, d k), all inside the limits."""
        normal = rng.standard_normal((count, len(self._free.mean)))
        if len(self._seen) > 0:
            velocities = rng.standard_normal((count * _STRIDE, len(self._seen)))
            drawn = self._drawn(velocities, _STRIDE)
            normal += product(drawn - product(normal, self._seen.T), self._seen)
        weights = self._free.mean + product(normal, self._root.T)
        # In what the walls hardly see, a motion may still leave the limits: it is moved back.
        limits, spread = (self._basis, self._bounds, self._scale), self._free.covariance
        return np.stack([moved_inside(Gaussian(each, spread), *limits) for each in weights])

    def _near(self, mode: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Rows (m, d k) of walls in reach, the way to each from the free mean, and to the mode."""
        size, count = len(self._scale), self._basis.count
        basis = self._basis(phases_of(self._basis))
        blocks = self._root.reshape(size, count, -1)
        curves = [product(basis, w.reshape(size, count).T) for w in (self._free.mean, mode)]
        rows, room, at_mode = [np.zeros((0, size * count))], [np.zeros(0)], [np.zeros(0)]
        for column, scale in enumerate(self._scale):
            spread = np.sqrt((product(basis, blocks[column]) ** 2).sum(axis=1))
            free, moved = (curve[:, column] for curve in curves)
            for side, bound in ((-1.0, self._bounds[0]), (1.0, self._bounds[1])):
                ahead = side * (bound[column] - free)
                done = side * (moved - free)
                near = np.minimum(ahead, ahead - done) < _NEAR * spread
                near &= spread > CERTAIN * scale
                # Half of the margin that the mode keeps is left for what lies between the phases.
                ahead -= 0.5 * np.minimum(MARGIN * scale, ahead - done)
                chosen = np.zeros((int(near.sum()), size, count))
                chosen[:, column] = side * basis[near]
                rows.append(chosen.reshape(len(chosen), size * count))
                room.append(ahead[near])
                at_mode.append(done[near])
        return np.concatenate(rows), np.concatenate(room), np.concatenate(at_mode)

    def _drawn(self, velocities: Float64Array, stride: int) -> Float64Array:
        """Every `stride`-th draw of what the walls see, one for each velocity, after the first."""
        first = np.random.default_rng(0).standard_normal((_FIRST, velocities.shape[1]))
        all_of = np.concatenate([first, velocities])
        drawn = core.sample_truncated_gaussian(self._walls, self._room, self._start, all_of)
        return np.asarray(drawn[_FIRST + stride - 1 :: stride])


def _matched(rng: np.random.Generator, count: int, size: int) -> Float64Array:
    """Normal vectors (count, size) whose mean is 0 and covariance 1, to rounding."""
    normal = rng.standard_normal((count, size))
    normal -= normal.mean(axis=0)
    spread = product(normal.T, normal) / count
    # With a root R of the covariance C, the inverse of R is R.T @ inv(C).
    return product(solve_definite(spread, normal.T).T, root_of(spread))


def _substituted(lower: Float64Array, right: Float64Array) -> Float64Array:
    """The solution (r,) of a system with a lower triangular matrix (r, r)."""
    solved = np.zeros(len(right))
    for i in range(len(right)):
        solved[i] = (right[i] - (lower[i, :i] * solved[:i]).sum()) / lower[i, i]
    return solved
