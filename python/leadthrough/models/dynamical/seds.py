"""SEDS: a Gaussian mixture regression whose every component is stable.

x' = sum_k h_k(x) A_k x with the posteriors h_k of a mixture of positions; A_k + A_k^T < 0 makes
|x|^2 fall everywhere: (|x|^2)' = sum_k h_k x^T (A_k + A_k^T) x < 0. The constraints hold by the
choice of the parameters, A_k = -(B_k B_k^T + e I) + W_k - W_k^T, and L-BFGS solves what is left,
where the paper has interior points. Ours: the samples near rest that are left out, the least
deviation of a component and the slowest decay.

Source: Khansari-Zadeh and Billard 2011, "Learning stable nonlinear dynamical systems with Gaussian
mixture models", IEEE Transactions on Robotics 27, 943-957.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import minimize
from scipy.special import logsumexp, softmax

from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.models.dynamical import linear_mixture
from leadthrough.models.dynamical.linear_mixture import GaussianGates, LinearMixture
from leadthrough.models.dynamical.model import DynamicalModel, Samples

OBJECTIVES = ("likelihood", "mse")
# The slowest decay of a linear part, per duration of the demonstrations.
_MIN_DECAY = 0.1
# A component is no thinner than this in any direction, so that likelihoods stay finite.
_MIN_DEVIATION = 0.02
# Logarithm of the least element of a whitening matrix's diagonal, so that a line search which
# steps far off finds finite values there.
_MIN_LOGARITHM = -300.0
_MAX_ITERATIONS = 500
_TOLERANCE = 1e-7  # relative gain of the objective
_LOG_2_PI = float(np.log(2.0 * np.pi))


@dataclass(frozen=True)
class SEDS(DynamicalModel):
    """The stable estimator of dynamical systems, for points, joints or poses.

    The distance from the goal never grows along its motions: demonstrations that go away from the
    goal are cut short.

    Attributes:
        components: number of components, 1 to 50.
        objective: "likelihood" of positions and velocities, or "mse", the mean squared error of the
            velocities.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
    """

    components: int = 6
    objective: Literal["likelihood", "mse"] = "likelihood"
    seed: int = 0

    system = LinearMixture
    slider = ("components", 1, 15)

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=50)
        check.choice(self.objective, "objective", OBJECTIVES)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> LinearMixture:
        start = _first_guess(samples, self.components, seed=self.seed)
        objective = _unlikelihood if self.objective == "likelihood" else _squared_error
        k, d = start.matrices.shape[:2]
        solution = _solved(start, lambda packed: objective(packed, k, d, samples.x, samples.v))
        return LinearMixture(solution.gates, solution.matrices, np.eye(samples.x.shape[1]))


def _first_guess(samples: Samples, components: int, *, seed: int) -> StableGMR:
    """The most likely mixture of positions and velocities, each component made stable."""
    x, v = samples.x, samples.v
    d = x.shape[1]
    mixture, spread, gains = linear_mixture.velocity_mixture(x, v, components, seed=seed)
    matrices = stable(gains)
    residuals = v[None] - x @ matrices.transpose(0, 2, 1)
    shares = mixture.responsibilities(np.hstack([x, v])).T
    scatter = (shares[:, :, None] * residuals).transpose(0, 2, 1) @ residuals
    noise = scatter / np.maximum(shares.sum(axis=1), 1e-9)[:, None, None] + 1e-2 * np.eye(d)
    gates = GaussianGates.of(mixture.weights, mixture.means[:, :d], spread + 1e-3 * np.eye(d))
    return StableGMR(gates, matrices, np.linalg.inv(np.linalg.cholesky(noise)))


@dataclass(frozen=True, eq=False)
class StableGMR(ShortRepr):
    """A mixture of positions and velocities whose components pass through the goal."""

    gates: GaussianGates  # the mixture of positions
    matrices: Float64Array  # matrices A_k (k, d, d) of the velocities' means A_k x
    roots: Float64Array  # whitening matrices (k, d, d) of the velocities about their means


def stable(matrices: Float64Array) -> Float64Array:
    """The nearest matrices (k, d, d) whose symmetric parts are at most -_MIN_DECAY."""
    symmetric = 0.5 * (matrices + matrices.transpose(0, 2, 1))
    values, vectors = np.linalg.eigh(symmetric)
    lowered = np.minimum(values, -_MIN_DECAY)
    raised = (vectors * lowered[:, None, :]) @ vectors.transpose(0, 2, 1)
    return np.asarray(matrices - symmetric + raised)


@dataclass(frozen=True, eq=False)
class _Parts:
    """Parts of a vector of parameters; whitening has the logarithms of its diagonal."""

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
    decay = -symmetric - 0.5 * _MIN_DECAY * np.eye(d)  # half of the margin: no root is singular
    parts = _Parts(
        start.gates.logits,
        start.gates.means,
        _log_diagonal(_triangular(start.gates.whitening)),
        np.asarray(np.linalg.cholesky(decay)),
        0.5 * skew,
        _log_diagonal(_triangular(start.roots)),
    )
    solution = minimize(
        objective,
        parts.packed(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": _MAX_ITERATIONS, "ftol": _TOLERANCE, "gtol": 1e-7, "maxcor": 20},
    )
    end = _Parts.of(solution.x, k, d)
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
    most = 1.0 / _MIN_DEVIATION
    result[:, i, i] = most / (1.0 + most * np.exp(-np.maximum(parts[:, i, i], _MIN_LOGARITHM)))
    return result


def _matrices(parts: _Parts) -> Float64Array:
    eye = 0.5 * _MIN_DECAY * np.eye(parts.means.shape[1])
    decay = parts.factors @ parts.factors.transpose(0, 2, 1) + eye
    return np.asarray(parts.skew - parts.skew.transpose(0, 2, 1) - decay)


def _gradient_of_matrices(parts: _Parts, slope: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Gradients in B_k and W_k of what has the gradients (k, d, d) in A_k."""
    transposed = slope.transpose(0, 2, 1)
    return -(slope + transposed) @ parts.factors, slope - transposed


def _gradient_of_whitening(
    upper: Float64Array, products: Float64Array, totals: Float64Array
) -> Float64Array:
    """The gradient in the parameters of whitening matrices of sums of weighted log densities."""
    i = np.arange(upper.shape[1])
    slope = -np.triu(products)
    diagonal = upper[:, i, i]
    most = 1.0 / _MIN_DEVIATION
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
    upper, roots = _exp_diagonal(parts.whitening), _exp_diagonal(parts.roots)
    matrices = _matrices(parts)
    offsets = x[None] - parts.means[:, None]
    residuals = v[None] - x @ matrices.transpose(0, 2, 1)
    at_positions, z = _log_densities(offsets, upper)
    at_velocities, y = _log_densities(residuals, roots)
    joint = at_positions + at_velocities + (parts.logits - logsumexp(parts.logits))
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
    at_positions, z = _log_densities(offsets, upper)
    weights = softmax(at_positions + parts.logits, axis=1).T  # (k, n)
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
