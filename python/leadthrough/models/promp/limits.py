"""The most likely motion of a ProMP that keeps limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.dense import product
from leadthrough.models.promp.gaussian import Gaussian

_PHASES_PER_WEIGHT = 10
# A motion stays this fraction of its reach inside the limits, so that it also keeps them between
# the phases that are checked.
MARGIN = 1e-3
_MOST_ROUNDS = 30
# The programme's residual is zero where it has no solution; far beyond any standard deviation.
_INFEASIBLE = 1e-7

Bounds = tuple[Float64Array, Float64Array]


def checked(lower: ArrayLike, upper: ArrayLike, width: int) -> Bounds:
    """Limits of `width` columns as read-only arrays."""
    limits = []
    for value, name in ((lower, "lower"), (upper, "upper")):
        try:
            limit = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise InvalidInput(f"{name}: expected {width} numbers, got {value!r}") from None
        if limit.shape != (width,) or np.isnan(limit).any():
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
    for _ in range(_MOST_ROUNDS):
        excess = _excess(product(rows, moved.reshape(len(scale), -1).T), bounds, scale)
        worst = _worst_of_each(excess)
        if not worst:
            return moved
        active = list(dict.fromkeys([*active, *worst]))
        constraints = np.stack([_constraint(rows, each, len(scale)) for each in active])
        limits = np.array([_limit(each, bounds, scale) for each in active])
        moved = _solved(weights, constraints, limits)
    raise _fixed_outside()


def phases_of(basis: Basis) -> Float64Array:
    """The phases (n,) at which limits are checked."""
    return np.linspace(0.0, 1.0, _PHASES_PER_WEIGHT * basis.count + 1)


def _fixed_outside() -> InvalidInput:
    return InvalidInput(
        "limits: expected limits that the motion can keep, but its via points or its narrow "
        "spread hold it outside them; widen the limits"
    )


def _excess(values: Float64Array, bounds: Bounds, scale: Float64Array) -> Float64Array:
    """How far values lie beyond lower and upper limits, as fractions (2, n, d) of the reach."""
    lower, upper = bounds
    return np.stack([(lower - values) / scale, (values - upper) / scale])


def _worst_of_each(excess: Float64Array) -> list[tuple[int, int, int]]:
    """The local maxima of each violation over the samples."""
    padded = np.pad(excess, ((0, 0), (1, 1), (0, 0)), constant_values=-np.inf)
    peak = (excess >= padded[:, :-2]) & (excess >= padded[:, 2:]) & (excess > 0.0)
    return [(int(i), int(j), int(side)) for side, i, j in np.argwhere(peak)]


def _constraint(rows: Float64Array, active: tuple[int, int, int], size: int) -> Float64Array:
    sample, column, side = active
    row = np.zeros((size, rows.shape[1]))
    row[column] = rows[sample] * (1.0 if side else -1.0)
    return row.ravel()


def _limit(active: tuple[int, int, int], bounds: Bounds, scale: Float64Array) -> float:
    _, column, side = active
    inside = float(bounds[1][column] if side else -bounds[0][column])
    return inside - MARGIN * float(scale[column])


def _solved(weights: Gaussian, constraints: Float64Array, limits: Float64Array) -> Float64Array:
    """The w that minimises |w - mean|^2 in the covariance's metric, constraints @ w <= limits.

    With w = mean + root z it is the least distance programme of Lawson and Hanson 1974, chapter 23.
    """
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
