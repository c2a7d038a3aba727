"""Mixtures of linear systems, x' = sum_k h_k(x) A_k x with weights h_k(x) >= 0; their learning.

With one matrix P > 0 for which P A_k + A_k^T P < 0 for all k, V = x^T P x falls along every
trajectory, wherever it starts and whatever the weights are: the goal is globally stable. The A_k
with the least squared error are found by a semidefinite programme.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from leadthrough import check
from leadthrough.check import FitError, Float64Array
from leadthrough.models.dynamical.field import Field, StoredArrays
from leadthrough.models.gaussians.fitting import fit_mixture
from leadthrough.models.gaussians.mixture import Mixture, monomials

_EXTRA = "stable"


@dataclass(frozen=True, eq=False)
class LinearMixture(Field):
    """A mixture of linear systems, stable by one quadratic energy.

    Attributes:
        gates: the weights h_k.
        matrices: matrices A_k (k, d, d).
        metric: matrix P (d, d) of the energy.
    """

    gates: Gates
    matrices: Float64Array
    metric: Float64Array

    name: ClassVar[str] = "linear_mixture"

    @property
    def size(self) -> int:
        return len(self.metric)

    def velocity(self, x: Float64Array) -> Float64Array:
        each = (x @ self._stacked).reshape(len(x), *self.matrices.shape[:2])
        return np.asarray((self.gates.weights(x)[:, :, None] * each).sum(axis=1))

    def energy(self, states: Float64Array) -> Float64Array:
        """Energies (n,), x^T P x."""
        return np.asarray((states @ self.metric * states).sum(axis=1))

    def power(self, states: Float64Array) -> Float64Array:
        return np.asarray(2.0 * (states @ self.metric * self.velocity(states)).sum(axis=1))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        return {"matrices": self.matrices, "metric": self.metric, **self.gates.arrays()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        return cls(GaussianGates.from_arrays(arrays), arrays["matrices"], arrays["metric"])

    @cached_property
    def _stacked(self) -> Float64Array:
        """All A_k^T beside each other, (d, k d)."""
        k, d, _ = self.matrices.shape
        return np.ascontiguousarray(self.matrices.reshape(k * d, d).T)


class Gates(Protocol):
    """Weights of k linear systems, all >= 0 everywhere."""

    def weights(self, x: Float64Array) -> Float64Array:
        """Weights (n, k) at positions (n, d)."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""


@dataclass(frozen=True, eq=False)
class GaussianGates(StoredArrays):
    """Probabilities of the k components of a Gaussian mixture: they sum to 1."""

    logits: Float64Array  # logarithms (k,) of the components' weights
    means: Float64Array  # means (k, d)
    whitening: Float64Array  # matrices (k, d, d) with whitening^T whitening the precision

    @staticmethod
    def of(weights: Float64Array, means: Float64Array, covariances: Float64Array) -> GaussianGates:
        """The gates of a mixture with weights (k,), means (k, d) and covariances (k, d, d)."""
        roots = np.linalg.inv(np.linalg.cholesky(covariances))
        return GaussianGates(np.log(weights), means, roots)

    def weights(self, x: Float64Array) -> Float64Array:
        joint = monomials(x) @ self._coefficients
        joint -= joint.max(axis=1, keepdims=True)
        np.exp(joint, out=joint)
        joint /= joint.sum(axis=1, keepdims=True)
        return np.asarray(joint)

    def squared(self, x: Float64Array) -> Float64Array:
        """Squared Mahalanobis distances (n, k) of positions (n, d) from the means."""
        volume = np.linalg.slogdet(self.whitening)[1]
        return np.asarray(2.0 * (self.logits + volume - monomials(x) @ self._coefficients))

    @cached_property
    def _coefficients(self) -> Float64Array:
        """Coefficients (m, k) of the logarithms of the weights as sums of monomials."""
        precision = np.einsum("kij,kil->kjl", self.whitening, self.whitening)
        linear = np.einsum("kij,kj->ki", precision, self.means)
        volume = np.linalg.slogdet(self.whitening)[1]
        constant = self.logits + volume - 0.5 * (linear * self.means).sum(axis=1)
        rows, columns = np.triu_indices(self.means.shape[1])
        doubled = np.where(rows == columns, -0.5, -1.0)
        quadratic = precision[:, rows, columns] * doubled
        return np.ascontiguousarray(np.hstack([constant[:, None], linear, quadratic]).T)


def velocity_mixture(
    x: Float64Array, v: Float64Array, components: int, *, seed: int
) -> tuple[Mixture, Float64Array, Float64Array]:
    """The most likely mixture of positions and velocities (n, d), covariances of x, gains of v."""
    d = x.shape[1]
    mixture = fit_mixture(np.hstack([x, v]), components, seed=seed, starts=1).mixture
    spread, cross = mixture.covariances[:, :d, :d], mixture.covariances[:, d:, :d]
    transposed = np.linalg.solve(spread, cross.transpose(0, 2, 1))
    return mixture, spread, np.asarray(transposed).transpose(0, 2, 1)


def stable_matrices(
    weights: Float64Array,
    x: Float64Array,
    v: Float64Array,
    *,
    metric: Float64Array,
    decay: float,
    ridge: float,
) -> Float64Array:
    """Matrices A_k with the least squared error of sum_k h_k(x) A_k x that make an energy fall.

    Args:
        weights: weights h_k(x) (n, k).
        x: positions (n, d).
        v: velocities (n, d) there.
        metric: matrix P (d, d) of the energy x^T P x.
        decay: least rate e at which it falls, P A_k + A_k^T P <= -2 e P.
        ridge: weight of the squared entries of A_k.

    Returns:
        Matrices (k, d, d).

    Raises:
        FitError: if the programme is not solved.
        MissingDependency: without the extra `stable`.
    """
    clarabel = check.package("clarabel", extra=_EXTRA)
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
    solution = solve_cone_programme(quadratic, linear, rows, bounds, cones)
    return solution.reshape(d, k, d).transpose(1, 0, 2)


def solve_cone_programme(
    quadratic: sparse.csc_matrix,
    linear: Float64Array,
    rows: sparse.csc_matrix,
    bounds: Float64Array,
    cones: Sequence[Any],
) -> Float64Array:
    """Minimiser of x^T Q x / 2 + q^T x subject to bounds - rows x in cones.

    Args:
        quadratic: upper triangle of Q (m, m).
        linear: q (m,).
        rows: matrix (n, m) of the constraints.
        bounds: their right sides (n,).
        cones: Clarabel's cones, whose sizes add up to n.

    Raises:
        FitError: if the programme is not solved.
        MissingDependency: without the extra `stable`.
    """
    clarabel = check.package("clarabel", extra=_EXTRA)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    solver = clarabel.DefaultSolver(quadratic, linear, rows, bounds, list(cones), settings)
    solution = solver.solve()
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        raise FitError(
            f"demonstrations: no stable system satisfies the constraints ({solution.status})"
        )
    return np.array(solution.x)


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
    blocks = []
    for i in range(d):  # variables of row i of every A_k
        for own in range(k):
            block = sparse.lil_matrix((size * k, d))
            block[own * size : (own + 1) * size] = entries[i].T
            blocks.append(block)
    return sparse.hstack(blocks, format="csc")
