"""Matrices of linear systems that share a quadratic energy: a convex programme."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from leadthrough import optional
from leadthrough.check import Float64Array
from leadthrough.errors import FitError

EXTRA = "stable"


def stable_matrices(
    weights: Float64Array,
    x: Float64Array,
    v: Float64Array,
    *,
    metric: Float64Array,
    decay: float,
    ridge: float,
) -> Float64Array:
    """Matrices A_k (k, d, d) with the least squared error of sum_k h_k A_k x."""
    clarabel = optional.load("clarabel", extra=EXTRA)
    n, k = weights.shape
    d = x.shape[1]
    features = (weights[:, :, None] * x[:, None, :]).reshape(n, k * d)
    normal = features.T @ features / n + ridge * np.eye(k * d)
    # Rows of all A_k beside each other are independent in the error: variables A[k, i, j] stand in
    # the order i, k, j.
    quadratic = sparse.triu(sparse.block_diag([normal] * d), format="csc")
    linear = -(features.T @ v / n).T.ravel()
    rows = _decreases(metric, k, d)
    bounds = np.tile(_triangle(-2.0 * decay * metric), k)
    cones = [clarabel.PSDTriangleConeT(d) for _ in range(k)]
    found = solved(quadratic, linear, rows, bounds, cones)
    return found.reshape(d, k, d).transpose(1, 0, 2)


def solved(
    quadratic: sparse.csc_matrix,
    linear: Float64Array,
    rows: sparse.csc_matrix,
    bounds: Float64Array,
    cones: Sequence[Any],
) -> Float64Array:
    """The x with the least x^T Q x / 2 + q^T x for which bounds - rows x lies in cones."""
    clarabel = optional.load("clarabel", extra=EXTRA)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    solver = clarabel.DefaultSolver(quadratic, linear, rows, bounds, list(cones), settings)
    found = solver.solve()
    if str(found.status) not in ("Solved", "AlmostSolved"):
        raise FitError(f"demonstrations: no stable system was found ({found.status})")
    return np.array(found.x)


def _triangle(matrix: Float64Array) -> Float64Array:
    """The upper triangle of a symmetric matrix by columns, off-diagonal entries times sqrt(2)."""
    d = len(matrix)
    columns, rows = np.tril_indices(d)
    scale = np.where(rows == columns, 1.0, np.sqrt(2.0))
    return np.asarray(matrix[rows, columns] * scale)


def _decreases(metric: Float64Array, k: int, d: int) -> sparse.csc_matrix:
    """The rows that take the variables to the triangles of P A_k + A_k^T P."""
    entries = np.empty((d, d, d * (d + 1) // 2))
    for i in range(d):
        for j in range(d):
            one = np.zeros((d, d))
            one[i, j] = 1.0
            entries[i, j] = _triangle(metric @ one + one.T @ metric)
    size = entries.shape[2]
    which = np.arange(k)
    blocks = []
    for i in range(d):  # variables of row i of every A_k
        for own in which:
            block = sparse.lil_matrix((size * k, d))
            block[own * size : (own + 1) * size] = entries[i].T
            blocks.append(block)
    return sparse.hstack(blocks, format="csc")
