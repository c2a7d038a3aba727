"""Products and solutions of dense systems that are the same whatever the number of threads.

NumPy's and SciPy's BLAS split large products among threads, and round differently for each number
of them.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough.check import Float64Array

_Floats: TypeAlias = NDArray[np.floating[Any]]
_TAKEN = -np.inf  # the variance left to a pivot that was used


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
