"""Products and solutions of dense systems that are the same whatever the number of threads.

NumPy's and SciPy's BLAS split large products among threads, and round differently for each number
of them.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array

_Floats: TypeAlias = NDArray[np.floating[Any]]


def product(left: _Floats, right: _Floats) -> Float64Array:
    """The product (n, m) of matrices (n, k) and (k, m)."""
    return _core.product(_rows(left), _rows(right))


def solve_definite(matrix: _Floats, right: _Floats) -> Float64Array:
    """The solution (n, m) of a system with a symmetric positive definite matrix (n, n).

    Raises:
        LinAlgError: if the matrix is not positive definite.
    """
    solved = _core.solve_definite(_rows(matrix), _rows(right))
    if solved.shape != right.shape:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    return solved


def _rows(matrix: _Floats) -> Float64Array:
    return np.ascontiguousarray(matrix, dtype=np.float64)
