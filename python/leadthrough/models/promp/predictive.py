"""Posterior predictive distribution of the next motion's weights: a Student t distribution.

A few demonstrations leave both the mean and the covariance of the weights uncertain. Under a
normal-inverse-Wishart prior, the weights of the next motion have a t distribution: a normal one
whose covariance is known up to a factor. The prior's covariance is a smooth kernel over the phase,
with the demonstrations' own variance. Its strength, and how smooth it is, are those under which
the rest of each demonstration is the most probable, given its beginning and the others.

Source: Murphy 2012, "Machine learning: a probabilistic perspective", section 4.6.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.repr import ShortRepr

# Candidates: demonstrations that the prior counts as, and its correlation lengths, in phase.
_STRENGTHS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
_LENGTHS = (0.08, 0.15, 0.3, 0.6)
_PRIORS = [(strength, length) for length in _LENGTHS for strength in _STRENGTHS]
# The choice where there are too few demonstrations to leave one out.
_NOMINAL = (4.0, 0.15)
_MIN_COUNT = 3
# More demonstrations than these are not left out in turn, so that the time stays bounded.
_MAX_LEFT_OUT = 12
# Phases that count as the beginning, and those of the rest that are judged.
_BEGINNING = np.linspace(0.0, 0.3, 16)
_REST = np.array([0.5, 0.7, 0.85, 1.0])
# One demonstration says nothing about the spread of others: a tenth of its reach is assumed.
_UNKNOWN_SPREAD = 0.1
# Fractions of the reach: the least standard deviation of a motion, and the noise that samples are
# taken to have besides their own.
_MIN_SPREAD = 1e-2
_MIN_NOISE = 1e-2
# Variance of each weight on its own, relative to the kernel's, so that nothing is ruled out.
_ROUGH = 1e-3


@dataclass(frozen=True, eq=False)
class PosteriorPredictive(ShortRepr):
    """A t distribution of the weights of a motion."""

    spread: Gaussian  # location and scale matrix of the weights (d k,)
    freedom: float = np.inf  # degrees of freedom; infinite for a normal distribution


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

    def _of(self, curves: Float64Array, prior_choice: tuple[float, float]) -> PosteriorPredictive:
        """The predictive distribution after curves (m, d k)."""
        strength, length = prior_choice
        count = len(curves)
        mean = curves.mean(axis=0)
        centred = curves - mean
        prior = np.kron(np.diag(self._variance(centred)), _kernel(self.basis, length))
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

    def _chosen(self, scores: Float64Array) -> tuple[float, float]:
        """Strength and length of the best prior by scores (candidates,)."""
        return _PRIORS[int(scores.argmax())] if len(self._scores) > 0 else _NOMINAL

    def _scores_of(self, i: int, others: Float64Array) -> list[float]:
        """Log densities of the rest of demonstration i, one for each candidate."""
        size, count = len(self.scale), len(others)
        rows = self.basis(np.concatenate([_BEGINNING, _REST]))
        # Values phase by phase, so that a Cholesky factor gives the rest after the beginning.
        mean = others.mean(axis=0)
        centred = _values(others - mean, rows, size)
        missed = _values((self.curves[i] - mean)[None], rows, size)[0]
        scatter, variance = centred.T @ centred, self._variance(others - mean)
        noise = np.diag(np.tile(self.noise + (_MIN_NOISE * self.scale) ** 2, len(rows)))
        priors = {
            length: np.kron(rows @ _kernel(self.basis, length) @ rows.T, np.diag(variance))
            for length in _LENGTHS
        }
        scores = []
        for strength, length in _PRIORS:
            freedom = count - 1 + strength
            spread = (scatter + strength * priors[length]) * ((1.0 + 1.0 / count) / freedom)
            scores.append(_log_density_of_rest(missed, spread + noise, freedom, size))
        return scores

    def _variance(self, centred: Float64Array) -> Float64Array:
        """Variance (d,) of each column of deviations (m, d k), over motions and phases."""
        count, size = len(centred), len(self.scale)
        if count == 1:
            return np.asarray((_UNKNOWN_SPREAD * self.scale) ** 2)
        rows = self.basis(np.linspace(0.0, 1.0, 4 * self.basis.count + 1))
        deviations = _values(centred, rows, size).reshape(count, len(rows), size)
        pooled = (deviations**2).mean(axis=1).sum(axis=0) / (count - 1)
        return np.asarray(pooled + (_MIN_SPREAD * self.scale) ** 2)


def common_noise(noises: Sequence[Float64Array], scales: Sequence[Float64Array]) -> Float64Array:
    """Variances (d,) of samples about any of several motions."""
    reach = np.mean(scales, axis=0)
    return np.asarray(np.mean(noises, axis=0) + (_MIN_NOISE * reach) ** 2)


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
def _kernel(basis: Basis, length: float) -> Float64Array:
    """Covariance (k, k) of the weights of curves of unit variance, correlated over a length."""
    phases = np.linspace(0.0, 1.0, 8 * basis.count + 1)
    gaps = phases[:, None] - phases
    if basis.is_rhythmic:
        gaps = np.sin(np.pi * gaps) / np.pi
    fit = np.linalg.pinv(basis(phases), rcond=1e-6)
    smooth = fit @ np.exp(-0.5 * (gaps / length) ** 2) @ fit.T
    return np.asarray(smooth + _ROUGH * np.eye(basis.count))
