"""Expectation maximisation for Gaussian mixtures.

Both steps are one matrix product each over the points' monomials 1, x_i and x_i x_j: a component's
log density is a quadratic form, and its sums of first and second order are the weighted monomials.
The iteration ends when the likelihood gains too little, an absolute number and not a ratio.
After every three steps the sums leap ahead to where the steps lead, which takes EM to the same
maximum in fewer iterations; a leap that loses likelihood is not made.

Source: Dempster, Laird and Rubin 1977, "Maximum likelihood from incomplete data via the EM
algorithm"; Varadhan and Roland 2008, "Simple and globally convergent methods for accelerating the
convergence of any EM algorithm", scheme S3, here for the sums instead of the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.gaussians.kmeans import clustered, seeds

# The least variance of a component in any direction, of columns scaled to variance one: a
# thousandth of the data's spread. Bounding a covariance from below by cutting off its eigenvalues
# maximises the likelihood under that bound, so that EM still never loses any.
MIN_VARIANCE = 1e-6
_TOLERANCE = 1e-6  # gain of the mean log-likelihood per point
# To which the best end goes on: the likelihood may hardly grow for 400 iterations, and the motion
# shall tell neither when they were ended nor how the units round.
_LAST_TOLERANCE = 1e-13
_MAX_ITERATIONS, _LAST_ITERATIONS = 500, 3000
# Ends whose mean log-likelihoods differ by less are at one maximum, or as good: the first is taken,
# not the one that rounding favours.
_AS_LIKELY = 1e-4
# Ways to begin that are tried for each start, and for how many iterations; the best go on.
_TRIALS, _TRIAL_ITERATIONS = 4, 40
_MAX_LEAP = 64.0  # steps; where sums lead further, they lead nowhere that rounding leaves


# The weighted monomials (k, m) of a mixture's components, in each block.
Sums = list[Float64Array]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Components over several blocks of columns, independent of each other within a component."""

    weights: Float64Array  # weights (k,) of the components
    means: tuple[Float64Array, ...]  # means (k, d) in each block
    covariances: tuple[Float64Array, ...]  # covariances (k, d, d) in each block


def fit_blocks(
    blocks: Sequence[Float64Array],
    clustering: Float64Array,
    count: int,
    *,
    seed: int,
    starts: int,
    least: float = MIN_VARIANCE,
) -> tuple[Blocks, list[float]]:
    """The most likely components of points given in blocks of columns, whatever their order."""
    rng = np.random.default_rng(seed)
    order = np.lexsort(np.hstack(blocks).T[::-1])
    blocks, clustering = [block[order] for block in blocks], clustering[order]
    steps = Steps(blocks, least=least)
    first = np.eye(count)
    if count == 1 or starts == 1:
        labels = clustered(clustering, seeds(clustering, count, rng)).labels
        begun = [steps.run(steps.maximise(first[labels]), _TRIAL_ITERATIONS)]
    else:
        begun = []
        for i in range(_TRIALS * starts):
            start = steps.maximise(first[_cells(clustering, count, i, rng)])
            begun.append(steps.run(start, _TRIAL_ITERATIONS))
    promising = sorted(range(len(begun)), key=lambda i: -begun[i][1][-1])[:starts]
    ends = []
    for components, history in (begun[i] for i in sorted(promising)):
        end, more = steps.run(components, _MAX_ITERATIONS)
        ends.append((end, history + more[1:]))
    enough = max(history[-1] for _, history in ends) - _AS_LIKELY
    best, history = next(end for end in ends if end[1][-1] >= enough)
    end, more = steps.run(best, _LAST_ITERATIONS, tolerance=_LAST_TOLERANCE)
    return end, history + more[1:]


def _cells(
    points: Float64Array, count: int, trial: int, rng: np.random.Generator
) -> NDArray[np.integer[Any]]:
    """For each of the points (n, c) the number of its cell in a trial."""
    centres = seeds(points, count, rng)
    if trial % 2 == 0:
        return clustered(points, centres).labels
    squared = ((points[:, None] - centres) ** 2).sum(axis=2)
    return np.asarray(squared.argmin(axis=1))


class Steps:
    """The two steps of EM for points in blocks of columns."""

    def __init__(
        self,
        blocks: Sequence[Float64Array],
        before: Sequence[Float64Array] | None = None,
        *,
        least: float = MIN_VARIANCE,
    ) -> None:
        self._sizes = [block.shape[1] for block in blocks]
        self._monomials = [monomials(block) for block in blocks]
        self._before = before
        self._least = least

    def bounded_by(self, least: float) -> Steps:
        """The steps for the same points with another least variance."""
        other = copy(self)
        other._least = least
        return other

    def run(
        self, components: Blocks, iterations: int, *, tolerance: float = _TOLERANCE
    ) -> tuple[Blocks, list[float]]:
        """The components after EM, and the mean log-likelihood per point at every iteration."""
        history: list[float] = []
        best, leapt = components, False
        trail: list[Sums] = []  # of the steps since the last leap
        for _ in range(iterations):
            responsibilities, likelihood = self.expect(components)
            if history and not likelihood > history[-1]:
                if not leapt:
                    break  # rounding is all that is left
                components, trail, leapt = self._of_sums(trail[-1]), [], False
                continue
            history.append(likelihood)
            best = components
            if leapt:
                trail = []
            elif len(history) > 1 and history[-1] - history[-2] < tolerance:
                break
            trail.append(self._sums(responsibilities))
            leap = _leap(trail[-3:]) if len(trail) >= 3 else None
            leapt = leap is not None
            components = self._of_sums(trail[-1] if leap is None else leap)
        return best, history

    def expect(self, components: Blocks) -> tuple[Float64Array, float]:
        """Responsibilities (n, k) of components, and the mean log-likelihood per point."""
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

    def maximise(self, responsibilities: Float64Array) -> Blocks:
        """The most likely components, given responsibilities."""
        return self._of_sums(self._sums(responsibilities))

    def _sums(self, responsibilities: Float64Array) -> Sums:
        return [responsibilities.T @ monomials for monomials in self._monomials]

    def _of_sums(self, sums: Sums) -> Blocks:
        """The most likely components of the points that have these weighted monomials."""
        if self._before is not None:
            sums = [own + before for own, before in zip(sums, self._before, strict=True)]
        counts = np.maximum(sums[0][:, 0], np.finfo(float).tiny)
        means, covariances = [], []
        for each, size in zip(sums, self._sizes, strict=True):
            mean = each[:, 1 : 1 + size] / counts[:, None]
            second = _squares(each[:, 1 + size :], size) / counts[:, None, None]
            means.append(mean)
            spread = second - mean[:, :, None] * mean[:, None, :]
            covariances.append(bounded(spread, self._least))
        return Blocks(counts / counts.sum(), tuple(means), tuple(covariances))

    def _of_before(self, coefficients: Sequence[Float64Array]) -> float:
        """Log-likelihood of the points seen before."""
        if self._before is None:
            return 0.0
        pairs = zip(self._before, coefficients, strict=True)
        return sum(float((sums * others).sum()) for sums, others in pairs)

    def _count(self) -> float:
        new = float(len(self._monomials[0]))
        return new if self._before is None else new + float(self._before[0][:, 0].sum())


def _leap(trail: Sequence[Sums]) -> Sums | None:
    """Where three sums in a row lead; None where that is no farther than a step."""
    first, second, third = trail
    steps = [b - a for a, b in zip(first, second, strict=True)]
    bends = [c - b - step for b, c, step in zip(second, third, steps, strict=True)]
    step, bend = (np.sqrt(sum(float((x**2).sum()) for x in each)) for each in (steps, bends))
    if not step > bend:
        return None
    length = min(step / bend, _MAX_LEAP) if bend > 0.0 else _MAX_LEAP
    parts = zip(first, steps, bends, strict=True)
    leap = [start + 2.0 * length * step + length**2 * bend for start, step, bend in parts]
    return leap if (leap[0][:, 0] > 0.0).all() else None


def sums_of(components: Blocks, count: float) -> Sums:
    """The weighted monomials (k, m), in each block, of the points that components stand for."""
    result = []
    for means, covariances in zip(components.means, components.covariances, strict=True):
        rows, columns = _triangle(means.shape[1])
        second = covariances + means[:, :, None] * means[:, None, :]
        monomials = np.hstack([np.ones((len(means), 1)), means, second[:, rows, columns]])
        result.append(monomials * (count * components.weights)[:, None])
    return result


@lru_cache(maxsize=64)
def _triangle(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the upper triangle of a square matrix."""
    return np.triu_indices(size)


def monomials(points: Float64Array) -> Float64Array:
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
    """Coefficients (k, 1 + d + d (d + 1) / 2) of the log densities as sums of monomials."""
    size = means.shape[1]
    precision = np.linalg.inv(covariances)
    linear = (precision @ means[:, :, None])[:, :, 0]
    volume = np.linalg.slogdet(covariances)[1]
    constant = -0.5 * ((linear * means).sum(axis=1) + volume + size * np.log(2.0 * np.pi))
    rows, columns = _triangle(size)
    doubled = np.where(rows == columns, -0.5, -1.0)
    quadratic = precision[:, rows, columns] * doubled
    return np.hstack([constant[:, None], linear, quadratic])


def bounded(covariances: Float64Array, least: float) -> Float64Array:
    """Covariances (k, d, d) with eigenvalues of at least a bound."""
    values, vectors = np.linalg.eigh(covariances)
    if values[:, 0].min() >= least:
        return covariances
    raised = np.maximum(values, least)
    return np.asarray((vectors * raised[:, None, :]) @ vectors.transpose(0, 2, 1))
