"""Gaussian mixtures fitted by expectation maximisation.

Both steps are one matrix product each over the points' monomials 1, x_i and x_i x_j: a component's
log density is a quadratic form, and its sums of first and second order are the weighted monomials.
Source: Dempster, Laird and Rubin 1977; stopped by the gain in likelihood, not by a ratio.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models.mixtures.kmeans import clustered, seeds
from leadthrough.models.mixtures.mixture import Mixture

# The least variance of a component in any direction, of columns scaled to variance one: a
# thousandth of the data's spread. Bounding a covariance from below by cutting off its eigenvalues
# maximises the likelihood under that bound, so that EM still never loses any.
LEAST_VARIANCE = 1e-6
_TOLERANCE = 1e-6  # gain of the mean log-likelihood of a point
_MOST_ITERATIONS = 500
# Every start is followed this far, the best ones to the end.
_STARTS = 10
_TRIAL_ITERATIONS = 20
_FINALISTS = 2
_PATIENCE = 3


@dataclass(frozen=True, eq=False)
class Fitted:
    """mixture: what EM ended at. history: the mean log-likelihood of a point at every iteration."""

    mixture: Mixture
    history: tuple[float, ...]

    @property
    def log_likelihood(self) -> float:
        """Of the mixture, mean of the points."""
        return self.history[-1]


def fit_mixture(points: Any, components: int, *, seed: int = 0) -> Fitted:
    """The mixture of some components that makes points (n, d) the most likely.

    The best of several starts from k-means; components in the order of their means' first column,
    which for motions is the time. Raises InvalidInput; FitError for fewer points than
    components.
    """
    data, count = _checked(points, components, seed)
    middle, scale = standard(data)
    scaled = (data - middle) / scale
    blocks, history = fit_blocks([scaled], scaled, count, seed)
    volume = float(np.log(scale).sum())
    return Fitted(_unscaled(blocks, middle, scale), tuple(value - volume for value in history))


def choose_components(points: Any, *, at_most: int = 15, seed: int = 0) -> Fitted:
    """The mixture of 1 to `at_most` components with the least Bayesian information criterion.

    The search ends where three numbers in a row have not lowered it. Raises InvalidInput.
    Source: Schwarz 1978, "Estimating the dimension of a model".
    """
    data = check.array(points, "points", shape=("n", "d"))
    most = min(check.integer(at_most, "at_most", at_least=1), len(data))
    best, least = 1, np.inf
    fits = {}
    for count in range(1, most + 1):
        fits[count] = fit_mixture(data, count, seed=seed)
        criterion = bic(fits[count], len(data))
        if criterion < least:
            best, least = count, criterion
        if count - best == _PATIENCE:
            break
    return fits[best]


def trace_mixture(points: Any, components: int, *, iterations: int, seed: int = 0) -> list[Mixture]:
    """The mixtures of points (n, d) after 0, 1, ... iterations of EM from one start by k-means.

    For pictures of what EM does. Raises InvalidInput, FitError as `fit_mixture`.
    """
    data, count = _checked(points, components, seed)
    rounds = check.integer(iterations, "iterations", at_least=0)
    middle, scale = standard(data)
    scaled = (data - middle) / scale
    steps = Steps([scaled])
    labels = clustered(scaled, seeds(scaled, count, np.random.default_rng(seed))).labels
    found = [steps.maximise(np.eye(count)[labels])]
    for _ in range(rounds):
        found.append(steps.maximise(steps.expect(found[-1])[0]))
    return [_unscaled(each, middle, scale) for each in found]


def bic(fit: Fitted, samples: int) -> float:
    """The Bayesian information criterion of a mixture fitted to so many points."""
    k, d = fit.mixture.count, fit.mixture.size
    free = k - 1 + k * d + k * d * (d + 1) // 2
    return free * float(np.log(samples)) - 2.0 * samples * fit.log_likelihood


def standard(data: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Means and standard deviations (d,) of columns; 1 where all values are the same."""
    scale = data.std(axis=0)
    middle = data.mean(axis=0)
    rounding = 1e-12 * np.abs(middle)
    return middle, np.where(scale > rounding, scale, 1.0)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Components seen in several blocks of columns, independent of each other in a component.

    weights: (k,). means, covariances: (k, d) and (k, d, d) of each block.
    """

    weights: Float64Array
    means: tuple[Float64Array, ...]
    covariances: tuple[Float64Array, ...]


def fit_blocks(
    blocks: Sequence[Float64Array], clustering: Float64Array, count: int, seed: int
) -> tuple[Blocks, list[float]]:
    """Components of points given in blocks of columns (n, d), of variance about one.

    clustering: (n, d) in which k-means seeds them. Returns them and the history of the mean
    log-likelihood.
    """
    rng = np.random.default_rng(seed)
    steps = Steps(blocks)
    trials = []
    for _ in range(_STARTS if count > 1 else 1):
        labels = clustered(clustering, seeds(clustering, count, rng)).labels
        start = steps.maximise(np.eye(count)[labels])
        trials.append(steps.run(start, _TRIAL_ITERATIONS))
    trials.sort(key=lambda trial: -trial[1][-1])
    ends = []
    for components, history in trials[:_FINALISTS]:
        end, more = steps.run(components, _MOST_ITERATIONS)
        ends.append((end, history + more[1:]))
    return max(ends, key=lambda end: end[1][-1])


class Steps:
    """The two steps of EM for points in blocks of columns.

    before: for each block the weighted monomials (k, m) of points that were seen before, whose
    components stay as they were assigned.
    """

    def __init__(
        self, blocks: Sequence[Float64Array], before: Sequence[Float64Array] | None = None
    ) -> None:
        self._sizes = [block.shape[1] for block in blocks]
        self._monomials = [_monomials(block) for block in blocks]
        self._before = before

    def run(self, components: Blocks, iterations: int) -> tuple[Blocks, list[float]]:
        """EM from components on, until the likelihood gains no more; and its history."""
        history: list[float] = []
        best = components
        for _ in range(iterations):
            shares, likelihood = self.expect(components)
            if history and likelihood <= history[-1]:
                break  # rounding is all that is left
            history.append(likelihood)
            best = components
            if len(history) > 1 and history[-1] - history[-2] < _TOLERANCE:
                break
            components = self.maximise(shares)
        return best, history

    def expect(self, components: Blocks) -> tuple[Float64Array, float]:
        """Responsibilities (n, k), and the mean log-likelihood of a point."""
        coefficients = [
            _coefficients(means, covariances)
            for means, covariances in zip(components.means, components.covariances, strict=True)
        ]
        coefficients[0][:, 0] += np.log(np.maximum(components.weights, np.finfo(float).tiny))
        # A row for each component: sums over few components are then sums of long rows.
        joint = coefficients[0] @ self._monomials[0].T
        for monomials, others in zip(self._monomials[1:], coefficients[1:], strict=True):
            joint += others @ monomials.T
        largest = joint.max(axis=0)
        joint -= largest
        np.exp(joint, out=joint)
        total = joint.sum(axis=0)
        joint /= total
        likelihood = float((np.log(total) + largest).sum())
        return joint.T, (likelihood + self._of_before(coefficients)) / self._count()

    def maximise(self, shares: Float64Array) -> Blocks:
        """The components that responsibilities (n, k) make the most likely."""
        sums = [shares.T @ monomials for monomials in self._monomials]
        if self._before is not None:
            sums = [own + before for own, before in zip(sums, self._before, strict=True)]
        counts = np.maximum(sums[0][:, 0], np.finfo(float).tiny)
        means, covariances = [], []
        for each, size in zip(sums, self._sizes, strict=True):
            mean = each[:, 1 : 1 + size] / counts[:, None]
            second = _squares(each[:, 1 + size :], size) / counts[:, None, None]
            means.append(mean)
            covariances.append(_bounded(second - mean[:, :, None] * mean[:, None, :]))
        return Blocks(counts / counts.sum(), tuple(means), tuple(covariances))

    def _of_before(self, coefficients: Sequence[Float64Array]) -> float:
        if self._before is None:
            return 0.0
        pairs = zip(self._before, coefficients, strict=True)
        return sum(float((sums * others).sum()) for sums, others in pairs)

    def _count(self) -> float:
        new = float(len(self._monomials[0]))
        return new if self._before is None else new + float(self._before[0][:, 0].sum())


def sums_of(components: Blocks, count: float) -> list[Float64Array]:
    """For each block the weighted monomials (k, m) of points that components stand for."""
    result = []
    for means, covariances in zip(components.means, components.covariances, strict=True):
        rows, columns = _triangle(means.shape[1])
        second = covariances + means[:, :, None] * means[:, None, :]
        monomials = np.hstack([np.ones((len(means), 1)), means, second[:, rows, columns]])
        result.append(monomials * (count * components.weights)[:, None])
    return result


def _checked(points: Any, components: int, seed: int) -> tuple[Float64Array, int]:
    data = check.array(points, "points", shape=("n", "d"))
    count = check.integer(components, "components", at_least=1)
    check.integer(seed, "seed", at_least=0)
    if count > len(data):
        raise FitError(f"components: {count} are too many for {len(data)} points")
    return data, count


def _unscaled(blocks: Blocks, middle: Float64Array, scale: Float64Array) -> Mixture:
    """The components of one block, in their columns' own units and order."""
    order = np.argsort(blocks.means[0][:, 0], kind="stable")
    return Mixture(
        blocks.weights[order],
        blocks.means[0][order] * scale + middle,
        blocks.covariances[0][order] * scale * scale[:, None],
    )


@lru_cache(maxsize=64)
def _triangle(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the upper triangle of a square matrix."""
    return np.triu_indices(size)


def _monomials(points: Float64Array) -> Float64Array:
    """1, x_i and, for i <= j, x_i x_j of points (n, d)."""
    rows, columns = _triangle(points.shape[1])
    ones = np.ones((len(points), 1))
    return np.hstack([ones, points, points[:, rows] * points[:, columns]])


def _squares(upper: Float64Array, size: int) -> Float64Array:
    """Symmetric matrices (k, d, d) of their upper triangles (k, d (d + 1) / 2)."""
    rows, columns = _triangle(size)
    full = np.empty((len(upper), size, size))
    full[:, rows, columns] = upper
    full[:, columns, rows] = upper
    return full


def _coefficients(means: Float64Array, covariances: Float64Array) -> Float64Array:
    """Of the components' log densities as sums of monomials, (k, 1 + d + d (d + 1) / 2)."""
    size = means.shape[1]
    precision = np.linalg.inv(covariances)
    linear = (precision @ means[:, :, None])[:, :, 0]
    volume = np.linalg.slogdet(covariances)[1]
    constant = -0.5 * ((linear * means).sum(axis=1) + volume + size * np.log(2.0 * np.pi))
    rows, columns = _triangle(size)
    doubled = np.where(rows == columns, -0.5, -1.0)
    quadratic = precision[:, rows, columns] * doubled
    return np.hstack([constant[:, None], linear, quadratic])


def _bounded(covariances: Float64Array) -> Float64Array:
    """Covariances (k, d, d) with eigenvalues of at least the least variance."""
    values, vectors = np.linalg.eigh(covariances)
    if values[:, 0].min() >= LEAST_VARIANCE:
        return covariances
    raised = np.maximum(values, LEAST_VARIANCE)
    return np.asarray((vectors * raised[:, None, :]) @ vectors.transpose(0, 2, 1))
