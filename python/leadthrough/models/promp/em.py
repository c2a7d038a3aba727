"""Weight distributions of ProMPs from noisy and partial demonstrations by EM.

Expectation: the weights of each demonstration given its samples. Maximisation: their mean and
covariance, with an inverse-Wishart prior, and the samples' noise.

Sources: Lazaric and Ghavamzadeh 2010, "Bayesian multi-task reinforcement learning";
Gomez-Gonzalez et al. 2020, "Adaptation and robust learning of probabilistic movement primitives",
section III.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.dense import (
    inverse_definite,
    log_determinant,
    product,
    solve_definite,
)
from leadthrough.models.promp.estimation import LEAST_COVERED, LEAST_SPREAD, Fit, Shown
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.prior import raised, smooth_prior

# The prior counts as much as this many demonstrations.
_PRIOR_COUNT = 0.1
_FIRST_NOISE = 0.01  # variance, of columns scaled to reach one
_LEAST_NOISE = 1e-5  # standard deviation as a fraction of the reach
_MOST_ITERATIONS = 200
# Gain in log posterior density, per observed number, below which the iteration ends.
_TOLERANCE = 1e-6
# Longest stretch of phases without a sample; beyond it only the prior would shape the motion.
_WIDEST_GAP = 0.25


@dataclass(frozen=True, eq=False)
class Sums:
    """A demonstration, reduced to what EM needs of it."""

    squares: Float64Array  # sums (k, k) of the products of basis functions
    products: Float64Array  # sums (k, d) of basis functions times values
    values: Float64Array  # sums (d,) of squared values
    count: int  # number of samples

    @staticmethod
    def of(rows: Float64Array, values: Float64Array) -> Sums:
        """The sums of samples with basis functions (n, k) and values (n, d)."""
        return Sums(
            product(rows.T, rows), product(rows.T, values), (values**2).sum(axis=0), len(values)
        )


def expectation_maximisation(basis: Basis, shown: Shown) -> Fit:
    """The distribution of weights and the noise under which the motions are the most probable."""
    _refuse_gaps(shown.phases, basis)
    pooled, scale = np.concatenate(shown.columns), shown.scale
    middle = pooled.mean(axis=0)
    sums = [
        Sums.of(basis(at), (values - middle) / scale)
        for at, values in zip(shown.phases, shown.columns, strict=True)
    ]
    size = len(scale)
    base = smooth_prior(basis, np.ones(size)) * _spread_of(sums, basis) ** 2
    first = Gaussian(_common_curve(sums, basis), base)
    weights, noise, history = _iterated(sums, first, base, _TOLERANCE * len(pooled) * size)
    estimates, _ = expectation(sums, weights, noise)
    unit = np.repeat(scale, basis.count)
    offset = np.repeat(middle, basis.count)
    mean = weights.mean * unit + offset
    covariance = raised(weights.covariance, basis, LEAST_SPREAD) * unit * unit[:, None]
    whole = [
        each.mean * unit + offset
        for each, u in zip(estimates, shown.phases, strict=True)
        if u[-1] - u[0] >= LEAST_COVERED
    ]
    curves = np.reshape(whole, (len(whole), len(mean)))
    return Fit(Gaussian(mean, covariance), noise * scale**2, curves, history)


def _iterated(
    sums: Sequence[Sums], weights: Gaussian, base: Float64Array, tolerance: float
) -> tuple[Gaussian, Float64Array, tuple[float, ...]]:
    """Weights, noise (d,) and history after EM from `weights` on, with the prior's `base`."""
    noise = np.full(len(sums[0].values), _FIRST_NOISE)
    history: list[float] = []
    for _ in range(_MOST_ITERATIONS):
        estimates, likelihood = expectation(sums, weights, noise)
        history.append(likelihood + log_prior(weights.covariance, base))
        if len(history) > 1 and history[-1] - history[-2] < tolerance:
            break
        weights, noise = maximisation(sums, estimates, base)
    return weights, noise, tuple(history)


def _common_curve(sums: Sequence[Sums], basis: Basis) -> Float64Array:
    """The weights (d k,) of the smooth curve through all demonstrations."""
    squares = np.sum([each.squares for each in sums], axis=0)
    products = np.sum([each.products for each in sums], axis=0)
    unit = float(np.trace(squares)) / basis.count
    smooth = squares + 1e-4 * unit * basis.roughness + 1e-9 * unit * np.eye(basis.count)
    return solve_definite(smooth, products).T.ravel()


def _spread_of(sums: Sequence[Sums], basis: Basis) -> float:
    """Root mean square distance of the demonstrations from their common curve."""
    curve = _common_curve(sums, basis).reshape(-1, basis.count)
    squared = sum(
        float(each.values.sum() - 2.0 * (curve.T * each.products).sum())
        + float(np.einsum("dk,kl,dl->", curve, each.squares, curve))
        for each in sums
    )
    total = sum(each.count for each in sums) * len(curve)
    return max(float(np.sqrt(max(squared / total, 0.0))), 0.01)


def expectation(
    sums: Sequence[Sums], weights: Gaussian, noise: Float64Array
) -> tuple[list[Gaussian], float]:
    """The weights of each demonstration, and the log-likelihood of all."""
    precision = inverse_definite(weights.covariance)
    pulled = _times(precision, weights.mean)
    prior_volume = log_determinant(weights.covariance)
    known: dict[bytes, tuple[Float64Array, float]] = {}
    estimates, likelihood = [], 0.0
    for each in sums:
        key = each.squares.tobytes()  # demonstrations at the same phases share their covariance
        if key not in known:
            added = precision + np.kron(np.diag(1.0 / noise), each.squares)
            known[key] = inverse_definite(added), log_determinant(added)
        covariance, log_volume = known[key]
        right = pulled + (each.products / noise).T.ravel()
        mean = _times(covariance, right)
        estimates.append(Gaussian(mean, covariance))
        squared = float(
            (each.values / noise).sum() + (weights.mean * pulled).sum() - (right * mean).sum()
        )
        log_noise = each.count * float(np.log(2.0 * np.pi * noise).sum())
        likelihood -= 0.5 * (squared + log_noise + prior_volume + log_volume)
    return estimates, likelihood


def _times(matrix: Float64Array, vector: Float64Array) -> Float64Array:
    return product(matrix, vector[:, None])[:, 0]


def maximisation(
    sums: Sequence[Sums], estimates: Sequence[Gaussian], base: Float64Array
) -> tuple[Gaussian, Float64Array]:
    """The distribution of the weights and the noise (d,) that the estimates make most probable."""
    means = np.stack([each.mean for each in estimates])
    mean = means.mean(axis=0)
    centred = means - mean
    total = product(centred.T, centred) + np.sum([each.covariance for each in estimates], axis=0)
    covariance = (total + _PRIOR_COUNT * base) / (len(means) + _PRIOR_COUNT)
    size = len(sums[0].values)
    squared = np.zeros(size)
    for each, estimate in zip(sums, estimates, strict=True):
        curve = estimate.mean.reshape(size, -1)
        blocks = estimate.covariance.reshape(size, -1, size, curve.shape[1])
        second = np.einsum("dkdl->dkl", blocks) + curve[:, :, None] * curve[:, None, :]
        squared += each.values - 2.0 * (curve.T * each.products).sum(axis=0)
        squared += np.einsum("kl,dkl->d", each.squares, second)
    noise = squared / sum(each.count for each in sums)
    return Gaussian(mean, covariance), np.maximum(noise, _LEAST_NOISE**2)


def log_prior(covariance: Float64Array, base: Float64Array) -> float:
    """Log density, up to a constant, of the inverse-Wishart prior that the maximisation follows."""
    trace = float(np.trace(solve_definite(covariance, base)))
    return -0.5 * _PRIOR_COUNT * (log_determinant(covariance) + trace)


def _refuse_gaps(phases: Sequence[Float64Array], basis: Basis) -> None:
    everything = np.sort(np.concatenate(phases) % 1.0 if basis.is_rhythmic else np.hstack(phases))
    gaps = np.diff(np.concatenate([[0.0], everything, [1.0]]))
    if gaps.max() > _WIDEST_GAP:
        at = float(np.concatenate([[0.0], everything])[int(np.argmax(gaps))])
        raise FitError(
            f"demonstrations: none shows the phases {at:.3g} to {at + gaps.max():.3g}; "
            "add one that shows this part"
        )
