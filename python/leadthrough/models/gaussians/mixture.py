"""Gaussian mixtures: their fit by expectation maximisation (EM) and the regression with them.

Both steps of EM are one matrix product each over the points' monomials 1, x_i and x_i x_j. After
every three steps the sums leap ahead to where the steps lead, unless that loses likelihood.

Sources: Dempster, Laird and Rubin 1977, "Maximum likelihood from incomplete data via the EM
algorithm"; Varadhan and Roland 2008, "Simple and globally convergent methods for accelerating the
convergence of any EM algorithm", scheme S3, here for the sums; Ghahramani and Jordan 1994,
"Supervised learning from incomplete data via an EM approach"; Calinon 2016, "A tutorial on
task-parameterized movement learning and retrieval", section 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.models.gaussians.kmeans import clustered, seeds

_SUM_TOLERANCE = 1e-6  # of weights that were rounded in a file


@dataclass(frozen=True, eq=False)
class Mixture(ShortRepr):
    """A mixture of k normal distributions of d columns.

    Attributes:
        weights: weights (k,), >= 0, of sum 1.
        means: means (k, d).
        covariances: covariances (k, d, d), positive definite.

    Raises:
        InvalidInput: if the shapes differ, the weights do not sum to 1 or a covariance is not
            positive definite.
    """

    weights: Float64Array
    means: Float64Array
    covariances: Float64Array

    def __init__(self, weights: ArrayLike, means: ArrayLike, covariances: ArrayLike) -> None:
        own_weights = check.frozen(weights, "weights", shape=("k",))
        own_means = check.frozen(means, "means", shape=(len(own_weights), "d"))
        shape = (*own_means.shape, own_means.shape[1])
        own_covariances = check.frozen(covariances, "covariances", shape=shape)
        if not (own_weights >= 0.0).all() or abs(own_weights.sum() - 1.0) > _SUM_TOLERANCE:
            raise InvalidInput(f"weights: expected fractions that sum to 1, got {own_weights}")
        vars(self).update(weights=own_weights, means=own_means, covariances=own_covariances)
        _ = self._whitening  # a covariance that is not positive definite is refused here

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.weights)

    @property
    def size(self) -> int:
        """Number of columns."""
        return int(self.means.shape[1])

    def log_density(self, points: ArrayLike) -> Float64Array:
        """Logarithm of the density at each point.

        Args:
            points: points (n, d).

        Returns:
            Logarithms (n,).
        """
        data = check.array(points, "points", shape=("n", self.size))
        return _log_sum(self._joint(data))

    def responsibilities(self, points: ArrayLike) -> Float64Array:
        """Probability that each point belongs to each component.

        Args:
            points: points (n, d).

        Returns:
            Probabilities (n, k).
        """
        joint = self._joint(check.array(points, "points", shape=("n", self.size)))
        return np.asarray(np.exp(joint - _log_sum(joint)[:, None]))

    def sample(self, count: int, *, seed: int) -> Float64Array:
        """Random points (count, d).

        Args:
            count: number of points, >= 1.
            seed: seed of the random number generator, >= 0.
        """
        size = check.affordable_count(count, "count", each=self.size**2)
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        which = rng.choice(self.count, size, p=self.weights / self.weights.sum())
        normal = rng.standard_normal((size, self.size))
        roots = np.linalg.cholesky(self.covariances)
        return np.asarray(self.means[which] + np.einsum("nij,nj->ni", roots[which], normal))

    def regress(
        self, values: ArrayLike, *, inputs: Sequence[int], outputs: Sequence[int] | None = None
    ) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of some columns, given the values of others.

        The covariance is that of the conditional mixture, by the law of total variance.

        Args:
            values: values (n, m) of the inputs.
            inputs: indices of m columns.
            outputs: indices of p other columns; by default all that are not inputs.

        Returns:
            Mean (n, p) and covariance (n, p, p) of the outputs.
        """
        given = self._columns(inputs, "inputs")
        rest = [column for column in range(self.size) if column not in given]
        chosen = rest if outputs is None else self._columns(outputs, "outputs")
        if not chosen or set(chosen) & set(given):
            raise check.refused("outputs", "at least one column, none of them an input", chosen)
        x = check.array(values, "values", shape=("n", len(given)))
        return self._conditioned(x, given, chosen)

    def _conditioned(
        self, x: Float64Array, given: list[int], chosen: list[int]
    ) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of the columns `chosen` at values x (n, m) of the columns `given`."""
        of_inputs = self.covariances[:, given][:, :, given]
        whitening = np.linalg.inv(np.linalg.cholesky(of_inputs))
        joint = _log_joint(self.weights, self.means[:, given], whitening, x)
        weights = np.exp(joint - _log_sum(joint)[:, None])  # of the components at each input
        cross = self.covariances[:, chosen][:, :, given]
        gains = cross @ whitening.transpose(0, 2, 1) @ whitening
        inner = self.covariances[:, chosen][:, :, chosen] - gains @ cross.transpose(0, 2, 1)
        offsets = x[None] - self.means[:, None, given]
        means = self.means[:, None, chosen] + offsets @ gains.transpose(0, 2, 1)  # (k, n, p)
        mean = np.einsum("nk,knp->np", weights, means)
        # The spread of the components' means about their mean, free of cancellation.
        apart = (means - mean).transpose(1, 2, 0)
        within = weights @ inner.reshape(self.count, -1)
        covariance = (apart * weights[:, None, :]) @ apart.transpose(0, 2, 1)
        covariance += within.reshape(covariance.shape)
        return mean, 0.5 * (covariance + covariance.transpose(0, 2, 1))

    def _columns(self, columns: Sequence[int], name: str) -> list[int]:
        chosen = [check.integer(c, name, at_least=0, at_most=self.size - 1) for c in columns]
        if not chosen or len(set(chosen)) != len(chosen):
            raise check.refused(name, "at least one column, each once", list(columns))
        return chosen

    @cached_property
    def _whitening(self) -> Float64Array:
        """Inverses of the lower roots of the covariances, (k, d, d)."""
        try:
            return np.asarray(np.linalg.inv(np.linalg.cholesky(self.covariances)))
        except np.linalg.LinAlgError:
            raise InvalidInput("covariances: expected positive definite matrices") from None

    def _joint(self, data: Float64Array) -> Float64Array:
        return _log_joint(self.weights, self.means, self._whitening, data)


def _log_joint(
    weights: Float64Array, means: Float64Array, whitening: Float64Array, data: Float64Array
) -> Float64Array:
    """Logarithms (n, k) of each component's weight times its density at points (n, d)."""
    offsets = data[None] - means[:, None]
    squared = ((offsets @ whitening.transpose(0, 2, 1)) ** 2).sum(axis=2)
    volumes = np.log(np.einsum("kii->ki", whitening)).sum(axis=1)
    with np.errstate(divide="ignore"):  # a component without weight has none anywhere
        constants = np.log(weights) + volumes - 0.5 * means.shape[1] * np.log(2.0 * np.pi)
    return np.asarray(constants - 0.5 * squared.T)


def _log_sum(values: Float64Array) -> Float64Array:
    """log sum exp (n,) over the last axis of values (n, k)."""
    largest = values.max(axis=1)
    return np.asarray(largest + np.log(np.exp(values - largest[:, None]).sum(axis=1)))


# The least variance of a component in any direction, of columns scaled to variance one: a
# thousandth of the data's spread. Bounding a covariance from below by cutting off its eigenvalues
# maximises the likelihood under that bound, so that EM still never loses any.
MIN_VARIANCE = 1e-6
_TOLERANCE = 1e-6  # gain of the mean log-likelihood per point
# To which the best end goes on: the likelihood may hardly grow for 400 iterations, and the motion
# shall tell neither when they were ended nor how the units round.
_LAST_TOLERANCE = 1e-13
_MAX_ITERATIONS, LAST_ITERATIONS = 500, 3000
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
    last_iterations: int = LAST_ITERATIONS,
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
    if last_iterations == 0:
        return best, history
    end, more = steps.run(best, last_iterations, tolerance=_LAST_TOLERANCE)
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
    """Limit that three sums in a row lead to; None if it is no farther than a step."""
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
