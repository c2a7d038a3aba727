"""The two objectives of SEDS and their gradients, over parameters without constraints.

A_k = -(B_k B_k^T + e I) + W_k - W_k^T fulfils A_k + A_k^T < 0 whatever B_k and W_k are, and a
covariance is positive definite by its triangular root. So the constraints of the paper's programme
hold by construction, and L-BFGS solves it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import logsumexp, softmax

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.gates import GaussianGates
from leadthrough.repr import ShortRepr

# The slowest decay of a linear part, per duration of the demonstrations.
SLOWEST = 0.1
# A component is no thinner than this in any direction, so that likelihoods stay finite.
_LEAST_DEVIATION = 0.02
# Logarithm of the least element of a whitening matrix's diagonal, so that a line search which
# steps far off finds finite values there.
_FARTHEST = -300.0
_MOST_ITERATIONS = 500
_TOLERANCE = 1e-7  # relative gain of the objective
_LOG_2_PI = float(np.log(2.0 * np.pi))


@dataclass(frozen=True, eq=False)
class StableGMR(ShortRepr):
    """A mixture of positions and velocities whose components pass through the goal."""

    gates: GaussianGates  # the mixture of positions
    matrices: Float64Array  # matrices A_k (k, d, d) of the velocities' means A_k x
    roots: Float64Array  # whitening matrices (k, d, d) of the velocities about their means


def stable(matrices: Float64Array) -> Float64Array:
    """The nearest matrices (k, d, d) whose symmetric parts are at most -SLOWEST."""
    symmetric = 0.5 * (matrices + matrices.transpose(0, 2, 1))
    values, vectors = np.linalg.eigh(symmetric)
    lowered = np.minimum(values, -SLOWEST)
    raised = (vectors * lowered[:, None, :]) @ vectors.transpose(0, 2, 1)
    return np.asarray(matrices - symmetric + raised)


def most_likely(start: StableGMR, x: Float64Array, v: Float64Array) -> StableGMR:
    """The mixture that makes positions x (n, d) and velocities v (n, d) most likely."""
    return _solved(start, lambda packed: _unlikelihood(packed, *_sizes(start), x, v))


def least_squares(start: StableGMR, x: Float64Array, v: Float64Array) -> StableGMR:
    """The mixture whose regression has the least mean squared error."""
    return _solved(start, lambda packed: _squared_error(packed, *_sizes(start), x, v))


def _sizes(start: StableGMR) -> tuple[int, int]:
    """Number of components and of columns."""
    return start.matrices.shape[0], start.matrices.shape[1]


@dataclass(frozen=True, eq=False)
class _Parts:
    """What a vector of parameters consists of; whitening has the logarithms of its diagonal."""

    logits: Float64Array
    means: Float64Array
    whitening: Float64Array
    factors: Float64Array
    skew: Float64Array
    roots: Float64Array

    def packed(self) -> Float64Array:
        return np.concatenate([each.ravel() for each in vars(self).values()])

    @staticmethod
    def of(packed: Float64Array, k: int, d: int) -> _Parts:
        sizes = [k, k * d, *[k * d * d] * 4]
        pieces = np.split(packed, np.cumsum(sizes)[:-1])
        shaped = [each.reshape(k, d, d) for each in pieces[2:]]
        return _Parts(pieces[0], pieces[1].reshape(k, d), *shaped)


def _solved(
    start: StableGMR, objective: Callable[[Float64Array], tuple[float, Float64Array]]
) -> StableGMR:
    k, d = start.matrices.shape[:2]
    symmetric = 0.5 * (start.matrices + start.matrices.transpose(0, 2, 1))
    skew = start.matrices - symmetric
    decay = -symmetric - 0.5 * SLOWEST * np.eye(d)  # half of the margin: no root is singular
    parts = _Parts(
        start.gates.logits,
        start.gates.means,
        _log_diagonal(_triangular(start.gates.whitening)),
        np.asarray(np.linalg.cholesky(decay)),
        0.5 * skew,
        _log_diagonal(_triangular(start.roots)),
    )
    found = minimize(
        objective,
        parts.packed(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": _MOST_ITERATIONS, "ftol": _TOLERANCE, "gtol": 1e-7, "maxcor": 20},
    )
    end = _Parts.of(found.x, k, d)
    gates = GaussianGates(end.logits, end.means, _exp_diagonal(end.whitening))
    return StableGMR(gates, _matrices(end), _exp_diagonal(end.roots))


def _triangular(whitening: Float64Array) -> Float64Array:
    """Upper triangular matrices (k, d, d) of the same precision."""
    precision = np.einsum("kij,kil->kjl", whitening, whitening)
    return np.linalg.cholesky(precision).transpose(0, 2, 1)


def _log_diagonal(upper: Float64Array) -> Float64Array:
    result = upper.copy()
    i = np.arange(upper.shape[1])
    result[:, i, i] = np.log(upper[:, i, i])
    return result


def _exp_diagonal(parts: Float64Array) -> Float64Array:
    result = np.triu(parts)
    i = np.arange(parts.shape[1])
    # A smooth bound: no deviation below the least one.
    most = 1.0 / _LEAST_DEVIATION
    result[:, i, i] = most / (1.0 + most * np.exp(-np.maximum(parts[:, i, i], _FARTHEST)))
    return result


def _matrices(parts: _Parts) -> Float64Array:
    eye = 0.5 * SLOWEST * np.eye(parts.means.shape[1])
    decay = parts.factors @ parts.factors.transpose(0, 2, 1) + eye
    return np.asarray(parts.skew - parts.skew.transpose(0, 2, 1) - decay)


def _gradient_of_matrices(parts: _Parts, slope: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Gradients in B_k and W_k of what has the gradients (k, d, d) in A_k."""
    turned = slope.transpose(0, 2, 1)
    return -(slope + turned) @ parts.factors, slope - turned


def _gradient_of_whitening(
    upper: Float64Array, products: Float64Array, totals: Float64Array
) -> Float64Array:
    """The gradient in the parameters of whitening matrices of sums of weighted log densities."""
    i = np.arange(upper.shape[1])
    slope = -np.triu(products)
    diagonal = upper[:, i, i]
    most = 1.0 / _LEAST_DEVIATION
    own = (slope[:, i, i] + totals[:, None] / diagonal) * diagonal * (1.0 - diagonal / most)
    slope[:, i, i] = own
    return slope


def _log_densities(offsets: Float64Array, upper: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Log densities (n, k) of offsets (k, n, d) from means, and the whitened offsets."""
    whitened = offsets @ upper.transpose(0, 2, 1)
    i = np.arange(upper.shape[1])
    volume = np.log(upper[:, i, i]).sum(axis=1)
    logs = volume[:, None] - 0.5 * (whitened**2).sum(axis=2)
    return (logs - 0.5 * upper.shape[1] * _LOG_2_PI).T, whitened


def _unlikelihood(
    packed: Float64Array, k: int, d: int, x: Float64Array, v: Float64Array
) -> tuple[float, Float64Array]:
    """The mean negative log-likelihood per sample, and its gradient."""
    parts = _Parts.of(packed, k, d)
    upper, roots, matrices = (
        _exp_diagonal(parts.whitening),
        _exp_diagonal(parts.roots),
        _matrices(parts),
    )
    offsets = x[None] - parts.means[:, None]
    residuals = v[None] - x @ matrices.transpose(0, 2, 1)
    places, z = _log_densities(offsets, upper)
    speeds, y = _log_densities(residuals, roots)
    joint = places + speeds + (parts.logits - logsumexp(parts.logits))
    total = logsumexp(joint, axis=1)
    shares = np.exp(joint - total[:, None]).T / len(x)  # (k, n)
    sums = shares.sum(axis=1)
    weighted = shares[:, :, None] * y
    pull = weighted @ roots  # (k, n, d)
    slope = np.einsum("knd,ne->kde", pull, x)
    factors, skew = _gradient_of_matrices(parts, slope)
    gradient = _Parts(
        sums - softmax(parts.logits),
        np.einsum("kn,knd,kde->ke", shares, z, upper),
        _gradient_of_whitening(upper, _outer(shares, z, offsets), sums),
        factors,
        skew,
        _gradient_of_whitening(roots, _outer(shares, y, residuals), sums),
    )
    return -float(total.mean()), -gradient.packed()


def _squared_error(
    packed: Float64Array, k: int, d: int, x: Float64Array, v: Float64Array
) -> tuple[float, Float64Array]:
    """Half the mean squared error of the regression, and its gradient."""
    parts = _Parts.of(packed, k, d)
    upper, matrices = _exp_diagonal(parts.whitening), _matrices(parts)
    offsets = x[None] - parts.means[:, None]
    places, z = _log_densities(offsets, upper)
    weights = softmax(places + parts.logits, axis=1).T  # (k, n)
    each = x @ matrices.transpose(0, 2, 1)  # (k, n, d)
    error = (weights[:, :, None] * each).sum(axis=0) - v
    slope = np.einsum("kn,nd,ne->kde", weights, error, x, optimize=True) / len(x)
    along = (each * error).sum(axis=2)
    pulls = weights * (along - (weights * along).sum(axis=0)) / len(x)
    factors, skew = _gradient_of_matrices(parts, slope)
    sums = pulls.sum(axis=1)
    gradient = _Parts(
        sums,
        np.einsum("kn,knd,kde->ke", pulls, z, upper),
        _gradient_of_whitening(upper, _outer(pulls, z, offsets), sums),
        factors,
        skew,
        np.zeros_like(parts.roots),
    )
    return 0.5 * float((error**2).sum(axis=1).mean()), gradient.packed()


def _outer(weights: Float64Array, a: Float64Array, b: Float64Array) -> Float64Array:
    """Sums (k, d, d) over n of weights (k, n) times the outer products of a and b (k, n, d)."""
    return np.asarray((weights[:, :, None] * a).transpose(0, 2, 1) @ b)
