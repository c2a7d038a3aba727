"""Weight distributions of ProMPs from demonstrations: by least squares, and by EM.

Least squares: a curve is fitted to each demonstration; the covariance of their weights is shrunk
towards a prior with the strength that minimises the expected squared error. EM, for noisy and
partial demonstrations, has an inverse-Wishart prior and estimates the samples' noise too.

Under a normal-inverse-Wishart prior, the weights of the next motion have a Student t distribution,
whose prior makes the rest of each demonstration most probable, given its beginning and the others.

Sources: Schaefer and Strimmer 2005, "A shrinkage approach to large-scale covariance matrix
estimation", eq. 8; Lazaric and Ghavamzadeh 2010, "Bayesian multi-task reinforcement learning";
Gomez-Gonzalez et al. 2020, "Adaptation and robust learning of probabilistic movement primitives",
section III; Murphy 2012, "Machine learning: a probabilistic perspective", section 4.6.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product as product_of

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import FitError, Float64Array, InvalidInput, ShortRepr
from leadthrough.models.promp import gaussian
from leadthrough.models.promp.basis import (
    Basis,
    prior_phases,
    raised,
    shaped_prior,
    smooth_prior,
    weights_of_values,
)
from leadthrough.models.promp.gaussian import Gaussian, log_determinant, product, solve_definite
from leadthrough.motion import Motion

# The least standard deviation that a motion is believed to have, as a fraction of its reach.
MIN_SPREAD = 3e-2
# A curve fitted to a smaller part of the phases than this is free to do anything in the rest.
MIN_COVERED = 0.9
# One demonstration says nothing about the spread of others: a tenth of its reach is assumed.
_UNKNOWN_SPREAD = 0.1
# The prior counts as at least this many demonstrations: the estimate knows nothing of it where two
# demonstrations deviate from their mean in opposite ways, as any two do.
_MIN_SHRINKAGE = 0.5
_MIN_NOISE = 1e-6  # standard deviation as a fraction of the reach
# The prior counts as much as this many demonstrations.
_PRIOR_COUNT = 0.1
_FIRST_NOISE = 0.01  # variance, of columns scaled to reach one
_MIN_EM_NOISE = 1e-5  # standard deviation as a fraction of the reach
_MAX_ITERATIONS = 200
# Gain in log posterior density, per observed number, below which the iteration ends.
_TOLERANCE = 1e-6
# Longest stretch of phases without a sample; beyond it only the prior would shape the motion.
_MAX_GAP = 0.25


@dataclass(frozen=True, eq=False)
class Samples:
    """Demonstrations as columns over phases.

    Attributes:
        phases: phases (n,) of the samples of each motion.
        columns: columns (n, d) of the samples of each motion.
        scale: reach (d,) of the motions.
    """

    phases: Sequence[Float64Array]
    columns: Sequence[Float64Array]
    scale: Float64Array


@dataclass(frozen=True, eq=False)
class Fit:
    weights: Gaussian  # distribution of the weights (d k,), one column after the other
    noise: Float64Array  # variances (d,) of the samples about their curves
    curves: Float64Array  # weights (m, d k) of the m demonstrations that show the whole motion
    history: tuple[float, ...] = ()


def fitted_curves(
    basis: Basis, samples: Samples, regularization: float
) -> tuple[Float64Array, Float64Array]:
    """The weights (m, d k) of a curve through each motion, and the variances (d,) about them."""
    curves, residuals = [], []
    known: dict[bytes, CurveFit] = {}
    for at, values in zip(samples.phases, samples.columns, strict=True):
        key = at.tobytes()
        if key not in known:
            known[key] = CurveFit(basis, at, regularization)
        fit = known[key]
        curves.append(fit.weights(values))
        residuals.append(((values - product(fit.values, curves[-1])) ** 2).sum(axis=0))
    count = sum(len(at) for at in samples.phases)
    free = max(count - len(curves) * basis.count, 1)
    noise = np.sum(residuals, axis=0) / free + (_MIN_NOISE * samples.scale) ** 2
    return np.stack([curve.T.ravel() for curve in curves]), noise


class CurveFit:
    """Least-squares curves through values at the same phases, exact at both ends."""

    def __init__(self, basis: Basis, phases: Float64Array, regularization: float) -> None:
        self.values = basis(phases)
        normal = product(self.values.T, self.values)
        unit = float(np.trace(normal)) / basis.count
        normal += regularization * unit * basis.roughness
        normal[np.diag_indices(basis.count)] += 1e-12 * unit
        self._solved = solve_definite(normal, self.values.T)
        ends = [0] if basis.is_rhythmic else [0, -1]
        self._ends = ends
        influence = solve_definite(normal, self.values[ends].T)
        self._to_ends = product(influence, np.linalg.pinv(self.values[ends] @ influence))

    def weights(self, values: Float64Array) -> Float64Array:
        """The weights (k, d) of curves through values."""
        middle = values.mean(axis=0)  # adds to all weights alike, as the functions sum to one
        free = product(self._solved, values - middle)
        missed = values[self._ends] - middle - self.values[self._ends] @ free
        return np.asarray(free + product(self._to_ends, missed) + middle)


def shrunk(stacked: Float64Array, basis: Basis, scale: Float64Array) -> Gaussian:
    """Mean and shrunk covariance of weight vectors."""
    count = len(stacked)
    mean = stacked.mean(axis=0)
    if count == 1:
        return Gaussian(mean, smooth_prior(basis, _UNKNOWN_SPREAD * scale))
    unit = np.repeat(scale, basis.count)  # makes the result independent of the columns' units
    centred = (stacked - mean) / unit
    sample = product(centred.T, centred) / (count - 1)
    target = shaped_prior(basis, centred.reshape(count, len(scale), basis.count))
    distance = float(((sample - target) ** 2).sum())
    shrinkage = _MIN_SHRINKAGE / count
    if distance > 0.0:
        shrinkage = max(shrinkage, min(_variance_of_sample(centred) / distance, 1.0))
    covariance = (1.0 - shrinkage) * sample + shrinkage * target
    covariance = raised(covariance, basis, MIN_SPREAD)
    return Gaussian(mean, covariance * unit * unit[:, None])


def _variance_of_sample(centred: Float64Array) -> float:
    """Estimated expected squared error of the sample covariance of rows (m, p)."""
    count = len(centred)
    gram = product(centred, centred.T)
    fourth = float((np.diag(gram) ** 2).sum())
    total = fourth - float((gram**2).sum()) / count
    return count / (count - 1) ** 3 * total


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


def expectation_maximisation(basis: Basis, samples: Samples) -> Fit:
    """The distribution of weights and the noise under which the motions are the most probable."""
    _refuse_gaps(samples.phases, basis)
    pooled, scale = np.concatenate(samples.columns), samples.scale
    middle = pooled.mean(axis=0)
    sums = [
        Sums.of(basis(at), (values - middle) / scale)
        for at, values in zip(samples.phases, samples.columns, strict=True)
    ]
    size = len(scale)
    base = smooth_prior(basis, np.ones(size)) * _spread_of(sums, basis) ** 2
    first = Gaussian(_common_curve(sums, basis), base)
    weights, noise, history = _iterated(sums, first, base, _TOLERANCE * len(pooled) * size)
    estimates, _ = expectation(sums, weights, noise)
    unit = np.repeat(scale, basis.count)
    offset = np.repeat(middle, basis.count)
    mean = weights.mean * unit + offset
    covariance = raised(weights.covariance, basis, MIN_SPREAD) * unit * unit[:, None]
    whole = [
        each.mean * unit + offset
        for each, u in zip(estimates, samples.phases, strict=True)
        if u[-1] - u[0] >= MIN_COVERED
    ]
    curves = np.reshape(whole, (len(whole), len(mean)))
    return Fit(Gaussian(mean, covariance), noise * scale**2, curves, history)


def _iterated(
    sums: Sequence[Sums], weights: Gaussian, base: Float64Array, tolerance: float
) -> tuple[Gaussian, Float64Array, tuple[float, ...]]:
    """Weights, noise (d,) and history after EM from `weights` on, with the prior's `base`."""
    noise = np.full(len(sums[0].values), _FIRST_NOISE)
    history: list[float] = []
    for _ in range(_MAX_ITERATIONS):
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
    precision = gaussian.inverse_definite(weights.covariance)
    pulled = _times(precision, weights.mean)
    prior_volume = log_determinant(weights.covariance)
    known: dict[bytes, tuple[Float64Array, float]] = {}
    estimates, likelihood = [], 0.0
    for each in sums:
        key = each.squares.tobytes()  # demonstrations at the same phases share their covariance
        if key not in known:
            added = precision + np.kron(np.diag(1.0 / noise), each.squares)
            known[key] = gaussian.inverse_definite(added), log_determinant(added)
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
    return Gaussian(mean, covariance), np.maximum(noise, _MIN_EM_NOISE**2)


def log_prior(covariance: Float64Array, base: Float64Array) -> float:
    """Log density, up to a constant, of the inverse-Wishart prior that the maximisation follows."""
    trace = float(np.trace(solve_definite(covariance, base)))
    return -0.5 * _PRIOR_COUNT * (log_determinant(covariance) + trace)


def _refuse_gaps(phases: Sequence[Float64Array], basis: Basis) -> None:
    everything = np.sort(np.concatenate(phases) % 1.0 if basis.is_rhythmic else np.hstack(phases))
    gaps = np.diff(np.concatenate([[0.0], everything, [1.0]]))
    if gaps.max() > _MAX_GAP:
        at = float(np.concatenate([[0.0], everything])[int(np.argmax(gaps))])
        raise FitError(
            f"demonstrations: none shows the phases {at:.3g} to {at + gaps.max():.3g}; "
            "add one that shows this part"
        )


def checked_phases(
    phases: Sequence[ArrayLike], motions: Sequence[Motion], *, rhythmic: bool
) -> list[Float64Array]:
    """A user's phases of the samples of motions, increasing and in [0, 1] unless rhythmic."""
    if not isinstance(phases, Sequence) or len(phases) != len(motions):
        got = len(phases) if isinstance(phases, Sequence) else type(phases).__name__
        raise check.refused("phases", f"one array per demonstration, {len(motions)}", got)
    checked = []
    for i, (given, motion) in enumerate(zip(phases, motions, strict=True)):
        name = f"phases[{i}]"
        u = check.array(given, name, shape=(len(motion.times),))
        if (np.diff(u) <= 0).any():
            at = int(np.argmax(np.diff(u) <= 0))
            raise InvalidInput(
                f"{name}: expected strictly increasing phases, "
                f"got {u[at]:.6g} then {u[at + 1]:.6g} at samples {at} and {at + 1}"
            )
        if not rhythmic and not (u[0] >= 0.0 and u[-1] <= 1.0):
            raise InvalidInput(f"{name}: expected phases in [0, 1], got {u[0]:.6g} to {u[-1]:.6g}")
        checked.append(u)
    return checked


def refuse_parts(phases: Sequence[Float64Array]) -> None:
    """Refuses motions that cover too small a part for least squares."""
    for i, u in enumerate(phases):
        if u[-1] - u[0] < MIN_COVERED:
            raise FitError(
                f"demonstrations[{i}]: covers only the phases {u[0]:.3g} to {u[-1]:.3g}; "
                'set estimator="em", which takes parts of a motion'
            )


# Candidates: demonstrations that the prior counts as, and its correlation lengths, in phase.
_STRENGTHS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
_LENGTHS = (0.08, 0.15, 0.3, 0.6)
# The mean deviation over the phases counts as so many demonstrations beside that of each phase.
_EVEN = (1.0, 1e6)
_PRIORS = list(product_of(_STRENGTHS, _LENGTHS, _EVEN))
# The choice where there are too few demonstrations to leave one out.
_NOMINAL = (4.0, 0.15, 1.0)
_MIN_COUNT = 3
# More demonstrations than these are not left out in turn, so that the time stays bounded.
_MAX_LEFT_OUT = 12
# Phases that count as the beginning, and those of the rest that are judged.
_BEGINNING = np.linspace(0.0, 0.3, 16)
_REST = np.array([0.5, 0.7, 0.85, 1.0])
# Fractions of the reach: the least standard deviation of a motion, and the noise that samples are
# taken to have besides their own.
_MIN_DEVIATION = 1e-2
_MIN_FORECAST_NOISE = 1e-2
# Variance of each weight on its own, relative to the kernel's, so that nothing is ruled out.
_ROUGH = 1e-3


@dataclass(frozen=True, eq=False)
class PosteriorPredictive(ShortRepr):
    """A t distribution of the weights of a motion."""

    spread: Gaussian  # location and scale matrix of the weights (d k,)
    freedom: float = np.inf  # degrees of freedom; infinite for a normal distribution

    @property
    def known(self) -> Gaussian:
        """Its mean and covariance; with few degrees of freedom it has none, and three count."""
        if np.isinf(self.freedom):
            return self.spread
        freedom = max(self.freedom, 3.0)
        return Gaussian(self.spread.mean, self.spread.covariance * (freedom / (freedom - 2.0)))


@dataclass(frozen=True, eq=False)
class Experience(ShortRepr):
    """The demonstrations of a skill, and the distribution of another motion that they imply."""

    basis: Basis  # the k basis functions
    curves: Float64Array  # weights (m, d k) of the demonstrations, one column after the other
    paces: Float64Array  # logarithms (n,) of the demonstrations' durations over the skill's
    noise: Float64Array  # variances (d,) of samples about their curves
    scale: Float64Array  # reach (d,) of the motions

    @cached_property
    def predictive(self) -> PosteriorPredictive:
        """The distribution of the next motion's weights."""
        return self._of(self.curves, self._chosen(self._scores.sum(axis=0)))

    @cached_property
    def left_out(self) -> Sequence[tuple[Float64Array, PosteriorPredictive]]:
        """Weights (d k,) of demonstrations, each with its predictive given the others."""
        if len(self.curves) < _MIN_COUNT:
            return ()
        # Nor does a demonstration say which prior it is judged by.
        others = self._scores.sum(axis=0) - self._scores
        return [
            (self.curves[i], self._of(rest, self._chosen(scores)))
            for (i, rest), scores in zip(_splits(self.curves), others, strict=True)
        ]

    def _of(self, curves: Float64Array, choice: Sequence[float]) -> PosteriorPredictive:
        """The predictive distribution after curves (m, d k)."""
        strength, length, even = choice
        count = len(curves)
        mean = curves.mean(axis=0)
        centred = curves - mean
        prior = _shaped(self.basis, length, self._deviations(centred, even))
        freedom = count - 1 + strength
        scatter = centred.T @ centred + strength * prior
        return PosteriorPredictive(
            Gaussian(mean, scatter * ((1.0 + 1.0 / count) / freedom)), freedom
        )

    @cached_property
    def _scores(self) -> Float64Array:
        """Log densities (n, candidates) of the rests of left-out demonstrations."""
        if len(self.curves) < _MIN_COUNT:
            return np.zeros((0, len(_PRIORS)))
        return np.array([self._scores_of(i, rest) for i, rest in _splits(self.curves)])

    def _chosen(self, scores: Float64Array) -> Sequence[float]:
        """Strength, length and evenness of the best prior by scores (candidates,)."""
        return _PRIORS[int(scores.argmax())] if len(self._scores) > 0 else _NOMINAL

    def _scores_of(self, i: int, others: Float64Array) -> list[float]:
        """Log densities of the rest of demonstration i, one for each candidate."""
        size, count = len(self.scale), len(others)
        rows = self.basis(np.concatenate([_BEGINNING, _REST]))
        # Values phase by phase, so that a Cholesky factor gives the rest after the beginning.
        mean = others.mean(axis=0)
        centred = _values(others - mean, rows, size)
        missed = _values((self.curves[i] - mean)[None], rows, size)[0]
        scatter = centred.T @ centred
        noise = np.diag(np.tile(self.noise + (_MIN_FORECAST_NOISE * self.scale) ** 2, len(rows)))
        by_column = np.kron(np.eye(size), rows).reshape(size, len(rows), -1)
        every = by_column.transpose(1, 0, 2).reshape(len(rows) * size, -1)
        priors = {
            (length, even): every @ _shaped(self.basis, length, deviations) @ every.T
            for even in _EVEN
            for deviations in [self._deviations(others - mean, even)]
            for length in _LENGTHS
        }
        scores = []
        for strength, length, even in _PRIORS:
            freedom = count - 1 + strength
            spread = (scatter + strength * priors[length, even]) * ((1.0 + 1.0 / count) / freedom)
            scores.append(_log_density_of_rest(missed, spread + noise, freedom, size))
        return scores

    def _deviations(self, centred: Float64Array, even: float) -> Float64Array:
        """Standard deviations (d, n) of each column at each phase, of deviations (m, d k)."""
        count, size = len(centred), len(self.scale)
        phases = prior_phases(self.basis)
        if count == 1:
            return np.repeat(_UNKNOWN_SPREAD * self.scale[:, None], len(phases), axis=1)
        rows = self.basis(phases)
        squared = (centred.reshape(count, size, -1) @ rows.T) ** 2
        pooled = squared.mean(axis=2, keepdims=True)
        own = (squared + (even / count) * pooled).sum(axis=0) / (count - 1 + even)
        return np.asarray(np.sqrt(own + (_MIN_DEVIATION * self.scale[:, None]) ** 2))


def _shaped(basis: Basis, length: float, deviations: Float64Array) -> Float64Array:
    """Covariance (d k, d k) of curves with deviations (d, n), correlated over a length."""
    fit, kernel = _kernel(basis, length)
    result = np.zeros((len(deviations), basis.count, len(deviations), basis.count))
    for column, own in enumerate(deviations):
        reached = fit * own
        rough = _ROUGH * float((own**2).mean()) * np.eye(basis.count)
        result[column, :, column] = reached @ kernel @ reached.T + rough
    return result.reshape(len(deviations) * basis.count, -1)


def common_noise(noises: Sequence[Float64Array], scales: Sequence[Float64Array]) -> Float64Array:
    """Variances (d,) of samples about any of several motions."""
    reach = np.mean(scales, axis=0)
    return np.asarray(np.mean(noises, axis=0) + (_MIN_FORECAST_NOISE * reach) ** 2)


def _splits(curves: Float64Array) -> Iterator[tuple[int, Float64Array]]:
    """Indices of left-out demonstrations, and the weights (m - 1, d k) of the others."""
    count = len(curves)
    for i in np.linspace(0, count - 1, min(count, _MAX_LEFT_OUT)).round().astype(int):
        yield int(i), np.delete(curves, i, axis=0)


def _values(weights: Float64Array, rows: Float64Array, size: int) -> Float64Array:
    """Values (m, n d) at n phases of curves with weights (m, d k)."""
    curves = weights.reshape(len(weights), size, -1) @ rows.T
    return curves.transpose(0, 2, 1).reshape(len(weights), -1)


def _log_density_of_rest(
    missed: Float64Array, spread: Float64Array, freedom: float, size: int
) -> float:
    """Log density of the values after the beginning, up to a constant of all candidates."""
    from scipy.linalg import solve_triangular
    from scipy.special import gammaln

    lower = np.linalg.cholesky(spread)
    rest = slice(len(_BEGINNING) * size, None)
    white = solve_triangular(lower, missed, lower=True)[rest]
    constant = gammaln(0.5 * (freedom + len(white))) - gammaln(0.5 * freedom)
    constant -= 0.5 * len(white) * np.log(freedom) + np.log(np.diag(lower)[rest]).sum()
    return float(constant - 0.5 * (freedom + len(white)) * np.log1p(white @ white / freedom))


@lru_cache(maxsize=64)
def _kernel(basis: Basis, length: float) -> tuple[Float64Array, Float64Array]:
    """The map (k, n) from values at phases to weights, and correlations (n, n) over a length."""
    phases = prior_phases(basis)
    gaps = phases[:, None] - phases
    if basis.is_rhythmic:
        gaps = np.sin(np.pi * gaps) / np.pi
    return weights_of_values(basis), np.asarray(np.exp(-0.5 * (gaps / length) ** 2))
