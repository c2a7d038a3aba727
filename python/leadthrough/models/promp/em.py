"""Weight distributions of ProMPs from noisy and partial demonstrations by EM.

Expectation: the weights of each demonstration given its samples. Maximisation: their mean and
covariance, with an inverse-Wishart prior, and the samples' noise. Source: Lazaric and Ghavamzadeh
2010, "Bayesian multi-task reinforcement learning"; Gomez-Gonzalez et al. 2020, "Adaptation and
robust learning of probabilistic movement primitives", section III.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.least_squares import LEAST_SPREAD, Fit
from leadthrough.models.promp.prior import smooth_prior

# The prior counts as much as this many demonstrations.
_PRIOR_COUNT = 0.1
_LEAST_NOISE = 1e-5  # standard deviation in shares of the reach
_MOST_ITERATIONS = 200
# Of the logarithm of the posterior density, for one value observed.
_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class _Seen:
    """A demonstration's sums: of the basis' squares (k, k), products with values (k, d)."""

    squares: Float64Array
    products: Float64Array
    values: Float64Array  # (d,) sums of squares
    count: int


def expectation_maximisation(
    basis: Basis,
    phases: Sequence[Float64Array],
    columns: Sequence[Float64Array],
    scale: Float64Array,
    *,
    history: list[float] | None = None,
) -> Fit:
    """phases: (n,) of each motion. columns: (n, d) of each. scale: (d,) their reach.

    history: takes the logarithm of the posterior density at every iteration. Raises FitError
    where a part of the motion was not shown at all.
    """
    _refuse_gaps(phases, basis)
    pooled = np.concatenate(columns)
    middle = pooled.mean(axis=0)
    shown = [
        _sums(basis(at), (values - middle) / scale)
        for at, values in zip(phases, columns, strict=True)
    ]
    size = len(scale)
    base = smooth_prior(basis, np.ones(size)) * _spread_of(shown, basis) ** 2
    floor = smooth_prior(basis, np.full(size, LEAST_SPREAD))
    weights, noise = Gaussian(_pooled(shown, basis), base), np.full(size, 0.01)
    reached = -np.inf
    for _ in range(_MOST_ITERATIONS):
        estimates, likelihood = _expectation(shown, weights, noise)
        density = likelihood + _log_prior(weights.covariance, base)
        if history is not None:
            history.append(density)
        if density - reached < _TOLERANCE * len(pooled) * size:
            break
        reached = density
        weights, noise = _maximisation(shown, estimates, base)
    unit = np.repeat(scale, basis.count)
    mean = weights.mean * unit + np.repeat(middle, basis.count)
    covariance = (weights.covariance + floor) * unit * unit[:, None]
    return Fit(Gaussian(mean, covariance), noise * scale**2)


def _sums(rows: Float64Array, values: Float64Array) -> _Seen:
    return _Seen(rows.T @ rows, rows.T @ values, (values**2).sum(axis=0), len(values))


def _pooled(shown: Sequence[_Seen], basis: Basis) -> Float64Array:
    """The weights (d k,) of the smooth curve through all demonstrations."""
    squares = np.sum([each.squares for each in shown], axis=0)
    products = np.sum([each.products for each in shown], axis=0)
    unit = float(np.trace(squares)) / basis.count
    smooth = squares + 1e-4 * unit * basis.roughness + 1e-9 * unit * np.eye(basis.count)
    return np.asarray(np.linalg.solve(smooth, products).T.ravel())


def _spread_of(shown: Sequence[_Seen], basis: Basis) -> float:
    """How far the demonstrations lie from their common curve, root mean square."""
    curve = _pooled(shown, basis).reshape(-1, basis.count)
    squared = sum(
        float(each.values.sum() - 2.0 * (curve.T * each.products).sum())
        + float(np.einsum("dk,kl,dl->", curve, each.squares, curve))
        for each in shown
    )
    total = sum(each.count for each in shown) * len(curve)
    return max(float(np.sqrt(max(squared / total, 0.0))), 0.01)


def _expectation(
    shown: Sequence[_Seen], weights: Gaussian, noise: Float64Array
) -> tuple[list[Gaussian], float]:
    """Each demonstration's weights, and the logarithm of the likelihood of all."""
    lower = np.linalg.cholesky(weights.covariance)
    inverse_lower = np.linalg.inv(lower)
    precision = inverse_lower.T @ inverse_lower
    pulled = precision @ weights.mean
    log_prior = 2.0 * float(np.log(np.diag(lower)).sum())
    known: dict[bytes, tuple[Float64Array, float]] = {}
    estimates, likelihood = [], 0.0
    for each in shown:
        key = each.squares.tobytes()
        if key not in known:
            posterior = precision + np.kron(np.diag(1.0 / noise), each.squares)
            log_volume = 2.0 * float(np.log(np.diag(np.linalg.cholesky(posterior))).sum())
            inverse = np.linalg.inv(posterior)
            known[key] = 0.5 * (inverse + inverse.T), log_volume
        covariance, log_volume = known[key]
        right = pulled + (each.products / noise).T.ravel()
        mean = covariance @ right
        estimates.append(Gaussian(mean, covariance))
        squared = float((each.values / noise).sum() + weights.mean @ pulled - right @ mean)
        log_noise = each.count * float(np.log(2.0 * np.pi * noise).sum())
        likelihood -= 0.5 * (squared + log_noise + log_prior + log_volume)
    return estimates, likelihood


def _maximisation(
    shown: Sequence[_Seen], estimates: Sequence[Gaussian], base: Float64Array
) -> tuple[Gaussian, Float64Array]:
    means = np.stack([each.mean for each in estimates])
    mean = means.mean(axis=0)
    centred = means - mean
    total = centred.T @ centred + np.sum([each.covariance for each in estimates], axis=0)
    covariance = (total + _PRIOR_COUNT * base) / (len(means) + _PRIOR_COUNT)
    size = len(shown[0].values)
    squared = np.zeros(size)
    for each, estimate in zip(shown, estimates, strict=True):
        curve = estimate.mean.reshape(size, -1)
        blocks = estimate.covariance.reshape(size, -1, size, curve.shape[1])
        second = np.einsum("dkdl->dkl", blocks) + curve[:, :, None] * curve[:, None, :]
        squared += each.values - 2.0 * (curve.T * each.products).sum(axis=0)
        squared += np.einsum("kl,dkl->d", each.squares, second)
    noise = squared / sum(each.count for each in shown)
    return Gaussian(mean, covariance), np.maximum(noise, _LEAST_NOISE**2)


def _log_prior(covariance: Float64Array, base: Float64Array) -> float:
    """Of the inverse-Wishart prior that the maximisation follows, but for a constant."""
    lower = np.linalg.cholesky(covariance)
    trace = float(np.trace(np.linalg.solve(covariance, base)))
    return -0.5 * _PRIOR_COUNT * (2.0 * float(np.log(np.diag(lower)).sum()) + trace)


def _refuse_gaps(phases: Sequence[Float64Array], basis: Basis) -> None:
    """Where no sample lies near, only the prior would say how the motion goes on."""
    everything = np.sort(np.concatenate(phases) % 1.0 if basis.is_rhythmic else np.hstack(phases))
    gaps = np.diff(np.concatenate([[0.0], everything, [1.0]]))
    if gaps.max() > 0.25:
        at = float(np.concatenate([[0.0], everything])[int(np.argmax(gaps))])
        raise FitError(
            f"demonstrations: none shows the phases {at:.3g} to {at + gaps.max():.3g}; "
            "show that part as well"
        )
