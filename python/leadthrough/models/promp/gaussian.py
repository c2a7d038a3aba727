"""Normal distributions of a vector, conditioned on linear observations, and their matrices.

Products and solutions of dense systems are the same whatever the number of threads: NumPy's and
SciPy's BLAS split large products among threads, and round differently for each number of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough.check import Float64Array, InvalidInput, ShortRepr

_Floats: TypeAlias = NDArray[np.floating[Any]]
_TAKEN = -np.inf  # the variance left to a pivot that was used
# Standard deviations below this fraction of the scale of what is observed count as zero: no
# observation moves the distribution in such a direction.
CERTAIN = 1e-7
# Fraction of the trace above which all variances surely are no rounding.
_VARYING = 1e-12
# An observation may differ by this fraction of the scale, in a direction without variance.
_CONTRADICTION = 1e-6


@dataclass(frozen=True, eq=False)
class Gaussian(ShortRepr):
    """A normal distribution of a vector."""

    mean: Float64Array  # mean (n,)
    covariance: Float64Array  # covariance (n, n), positive semi-definite

    @cached_property
    def root(self) -> Float64Array:
        """A matrix R (n, n) with R @ R.T equal to the covariance."""
        values, vectors = np.linalg.eigh(self.covariance)
        rounding = len(values) * np.finfo(np.float64).eps * values[-1]
        return np.asarray(vectors * np.sqrt(np.where(values > rounding, values, 0.0)))

    @cached_property
    def steady_root(self) -> Float64Array:
        """Another such matrix R, the same whatever the number of threads."""
        return root_of(self.covariance)

    @cached_property
    def certain(self) -> Float64Array:
        """An orthonormal basis (n, m) of the directions that do not vary."""
        less = self.covariance.copy()
        less[np.diag_indices(len(less))] -= _VARYING * np.trace(less)
        try:  # far quicker than eigenvalues
            np.linalg.cholesky(less)
            return np.empty((len(self.mean), 0))
        except np.linalg.LinAlgError:
            pass
        values, vectors = np.linalg.eigh(self.covariance)
        return np.asarray(vectors[:, values <= CERTAIN**2 * values[-1]])

    def columns_at(self, rows: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Mean (m, d) and covariance (m, d, d) of columns whose weights are a vector (d k,)."""
        count = rows.shape[1]
        size = len(self.mean) // count
        blocks = self.covariance.reshape(size, count, size, count).transpose(1, 3, 0, 2)
        pairs = (rows[:, :, None] * rows[:, None, :]).reshape(len(rows), -1)
        covariance = product(pairs, blocks.reshape(count**2, size**2))
        return rows @ self.mean.reshape(size, count).T, covariance.reshape(-1, size, size)

    def draw(self, count: int, rng: np.random.Generator) -> Float64Array:
        """Random vectors (count, n)."""
        normal = rng.standard_normal((count, len(self.mean)))
        return self.mean + product(normal, self.steady_root.T)

    def observe(
        self,
        rows: Float64Array,
        value: Float64Array,
        noise: Float64Array | None,
        *,
        scale: Float64Array,
        name: str,
    ) -> Gaussian:
        """The distribution of x after observing rows @ x."""
        spread = rows @ self.covariance
        innovation = spread @ rows.T
        if noise is not None:
            innovation = innovation + noise
        units = 1.0 / scale
        variances, axes = np.linalg.eigh(innovation * units * units[:, None])
        surprise = (value - rows @ self.mean) * units
        if variances[0] <= CERTAIN**2:
            uncertain = variances > CERTAIN**2
            variances, axes = variances[uncertain], axes[:, uncertain]
            _refuse_contradiction(surprise - axes @ (axes.T @ surprise), name)
        whitened = (axes / np.sqrt(variances)).T * units
        step = whitened @ spread
        mean = self.mean + ((whitened * scale) @ surprise) @ step
        covariance = step.T @ step
        return Gaussian(mean, np.subtract(self.covariance, covariance, out=covariance))


def _refuse_contradiction(missed: Float64Array, name: str) -> None:
    """Refuses an observation that misses what is fixed by fractions (p,) of its scale."""
    farthest = np.abs(missed).max()
    if farthest > _CONTRADICTION:
        raise InvalidInput(
            f"{name}: expected a value that agrees with the points fixed before, got one that "
            f"misses them by {farthest:.3g} times the motion's extent"
        )


def product(left: _Floats, right: _Floats) -> Float64Array:
    """The product (n, m) of matrices (n, k) and (k, m)."""
    return core.product(_rows(left), _rows(right))


def solve_definite(matrix: _Floats, right: _Floats) -> Float64Array:
    """The solution (n, m) of a system with a symmetric positive definite matrix (n, n)."""
    solved = core.solve_definite(_rows(matrix), _rows(right))
    if solved.shape != right.shape:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    return solved


def inverse_definite(matrix: Float64Array) -> Float64Array:
    """The inverse (n, n) of a symmetric positive definite matrix, symmetric to the last bit."""
    inverse = solve_definite(matrix, np.eye(len(matrix)))
    return np.asarray(0.5 * (inverse + inverse.T))


def log_determinant(matrix: Float64Array, *, least: float = 0.0) -> float:
    """The logarithm of the determinant of a symmetric positive definite matrix (n, n)."""
    _, pivots = _factorised(matrix, least)
    missing = len(matrix) - len(pivots)
    if missing and least == 0.0:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    return float(np.log(pivots).sum()) + (missing * float(np.log(least)) if missing else 0.0)


def root_of(matrix: Float64Array) -> Float64Array:
    """A matrix R (n, n) with R @ R.T equal to a symmetric positive semi-definite matrix."""
    largest = np.diag(matrix).max(initial=0.0)
    return _factorised(matrix, len(matrix) * np.finfo(np.float64).eps * largest)[0]


def row_basis(rows: Float64Array, *, least: float) -> tuple[Float64Array, list[int]]:
    """Orthonormal vectors that span the rows of a matrix, and the rows that they come from."""
    left = rows.copy()
    squared = np.einsum("ij,ij->i", left, left)
    smallest = least**2 * squared.max(initial=0.0)
    axes, chosen = np.zeros((0, rows.shape[1])), []
    while len(axes) < min(rows.shape):
        row = int(np.argmax(squared))
        if squared[row] <= smallest:
            break
        # Once more, as what is left of the row has rounding errors of the whole row.
        axis = left[row] - np.einsum("ij,i->j", axes, np.einsum("ij,j->i", axes, left[row]))
        axis /= np.sqrt((axis**2).sum())
        left -= np.einsum("ij,j->i", left, axis)[:, None] * axis
        squared = np.einsum("ij,ij->i", left, left)
        axes = np.vstack([axes, axis])
        chosen.append(row)
    return axes, chosen


def _factorised(matrix: Float64Array, least: float) -> tuple[Float64Array, Float64Array]:
    """The root (n, n) by Cholesky's method with pivots, and those pivots that exceed `least`."""
    size = len(matrix)
    root, left = np.zeros((size, size)), np.diag(matrix).copy()
    pivots: list[float] = []
    for step in range(size):
        chosen = int(np.argmax(left))
        if left[chosen] <= least:
            break
        pivots.append(float(left[chosen]))
        # einsum adds up in a loop of its own, in one order.
        known = np.einsum("ij,j->i", root[:, :step], root[chosen, :step])
        column = (matrix[:, chosen] - known) / np.sqrt(left[chosen])
        column[left == _TAKEN] = 0.0
        root[:, step] = column
        left -= column**2
        left[chosen] = _TAKEN
    return root, np.array(pivots)


def _rows(matrix: _Floats) -> Float64Array:
    return np.ascontiguousarray(matrix, dtype=np.float64)
