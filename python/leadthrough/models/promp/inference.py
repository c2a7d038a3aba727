"""Probability, duration and continuation of a motion that has begun, from its first samples.

Given the factor of its covariance, the t distribution of the weights is normal; the factor is
integrated over a grid, and corrected by left-out demonstrations. The result is a mixture over the
durations.

Sources: Maeda et al. 2017, "Phase estimation for fast action recognition and trajectory generation
in human-robot collaboration"; Murphy 2012, "Machine learning: a probabilistic perspective",
section 4.6.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Generic

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.models.promp.basis import Basis, multiplied, prior_phases
from leadthrough.models.promp.combination import alike
from leadthrough.models.promp.conditioning import check_seen
from leadthrough.models.promp.estimation import Experience, PosteriorPredictive, common_noise
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.model import ProMPSkill
from leadthrough.motion import Motion, MotionT, MotionT_co

# More samples add nothing: neighbours are not independent.
_MAX_SAMPLES = 50
# Logarithms of durations that are tried, over the skill's.
_PACES = np.log(np.geomspace(0.4, 2.5, 37))
# People's durations: standard deviation of the logarithm where nothing is known, and the
# fraction of motions that go at another pace than the demonstrations.
_PACE_SPREAD = 0.25
_UNUSUAL = 0.1
# Demonstrations of one duration: the least standard deviation, which counts as one of them.
_MIN_PACE_SPREAD = 0.03
_STEPS = np.linspace(-3.0, 3.0, 13)  # paces tried about the demonstrated ones, in deviations
_REFINED = 9  # paces tried between the best one's neighbours, twice
# Durations less probable than this, relative to the best one, are left out of the mixture.
_MIN_PROBABILITY = 1e-3
# Instants of left-out forecasts that are judged, as fractions of the part that was not seen.
_JUDGED = np.array([0.1, 0.4, 0.7, 1.0])
# Left-out demonstrations are forecast at paces that are off by this many standard deviations.
_OFF_PACE = 1.15
# That the covariance is right as it stands counts as one left-out demonstration.
_KNOWN = 1
# Logarithms of the factors that the covariance is tried with.
_FACTORS = np.linspace(-3.0, 5.5, 86)
# Directions with less information from the samples than this, relative to the most, are unseen.
_UNSEEN = 1e-12

# The weights (d k,) of a demonstration, and what the others predict.
LeftOut = tuple[Float64Array, PosteriorPredictive]


@dataclass(frozen=True, eq=False)
class Region(ShortRepr):
    """Ellipsoids that a motion is expected to be in, one at each of n times.

    Attributes:
        mean: their centres (n, d).
        shape: matrices (n, d, d); y is inside where (y - mean) @ inv(shape) @ (y - mean) <= 1.
    """

    mean: Float64Array
    shape: Float64Array

    @property
    def reach(self) -> Float64Array:
        """How far (n, d) the ellipsoids reach to either side of the mean in each column."""
        return np.asarray(np.sqrt(np.einsum("nii->ni", self.shape)))

    def contains(self, columns: ArrayLike) -> Float64Array:
        """Whether each of n points (n, d) lies in its ellipsoid, (n,).

        Args:
            columns: points (n, d); for poses as `Coordinates.columns` gives them.
        """
        away = check.array(columns, "columns", shape=self.mean.shape) - self.mean
        solved = np.linalg.solve(self.shape, away[:, :, None])[:, :, 0]
        return np.asarray((away * solved).sum(axis=1) <= 1.0)


@dataclass(frozen=True, eq=False)
class Inference(ShortRepr, Generic[MotionT_co]):
    """Result of `infer` from the beginning of a motion; entry i is about skill i.

    Attributes:
        probabilities: probability (k,) of each skill.
        durations: the expected duration (k,) of the whole motion under each skill, s.
        phases: the phase (k,) at which the observed part ends, in (0, 1].
        skills: the k skills conditioned on the observed part, with the new durations. Their
            `distribution` is the mean and the covariance of the forecast, whose uncertainty
            includes that of mean, covariance and duration from few demonstrations.
        freedom: degrees of freedom (k,) of the t distributions with these moments.
    """

    probabilities: Float64Array
    durations: Float64Array
    phases: Float64Array
    skills: tuple[ProMPSkill[MotionT_co], ...]
    freedom: Float64Array

    @property
    def best(self) -> int:
        """Index of the most probable skill."""
        return int(np.argmax(self.probabilities))

    def region(
        self, times: ArrayLike, *, skill: int | None = None, probability: float = 0.95
    ) -> Region:
        """Region of the expected motion, its samples as noisy as the demonstrations.

        The ellipsoids hold the motion with this probability at each time on its own, not at all
        times at once. They are those of a t distribution with `freedom` degrees of freedom and
        the moments that the skill's `distribution` gives.

        Args:
            times: times (n,) since the start of the motion, s, in [0, duration].
            skill: index of the skill; by default the most probable one.
            probability: probability that a region holds, in (0, 1).
        """
        check.number(probability, "probability", above=0.0, below=1.0)
        chosen = self.best if skill is None else skill
        check.integer(chosen, "skill", at_least=0, at_most=len(self.skills) - 1)
        expected = self.skills[chosen]
        mean, covariance = expected.distribution(times)
        covariance = covariance + np.diag(expected.noise)
        return Region(mean, covariance * self._radius(mean.shape[1], chosen, probability))

    def _radius(self, size: int, skill: int, probability: float) -> float:
        """Squared Mahalanobis distance, by the covariance, at which a region ends."""
        from scipy.stats import chi2, f as fisher

        freedom = float(self.freedom[skill])
        if np.isinf(freedom):
            return float(chi2.ppf(probability, size))
        return size * float(fisher.ppf(probability, size, freedom)) * (freedom - 2.0) / freedom


@one_blas_thread
def infer(
    observed: Motion, skills: Sequence[ProMPSkill[MotionT]], *, prior: ArrayLike | None = None
) -> Inference[MotionT]:
    """Probability, duration and continuation of a motion under each of several skills.

    A skill as it was fitted is taken with all the uncertainty that few demonstrations leave about
    it: see `Inference.region`. One that has been conditioned or combined since, or was saved
    by version 0.1, is taken as the normal distribution that it is, and its probability comes
    out too close to 0 or 1, its region too small, with a dozen demonstrations or fewer.

    Args:
        observed: first part of a motion, from its start on, at least two samples, of the skills'
            type.
        skills: k skills of one motion type; joints in any order, the first one's counts.
        prior: probabilities (k,) before anything is observed, >= 0; by default equal.

    Raises:
        InvalidInput: if the motion has fewer than two samples or another type, if the skills
            differ in type, or if the prior is negative or all 0.
    """
    skills = alike(skills)
    check_seen(observed, "observed")
    before = _prior(prior, len(skills))
    noise = common_noise([each.noise for each in skills], [each.scale for each in skills])
    continuations = [_in_best_mode(observed, skill, noise) for skill in skills]
    with np.errstate(divide="ignore"):
        evidence = np.log(before) + [each.evidence for each in continuations]
    probabilities = np.exp(evidence - evidence.max())
    durations = np.array([each.duration for each in continuations])
    forecasts = [each.forecast() for each in continuations]
    return Inference(
        probabilities / probabilities.sum(),
        durations,
        np.minimum(observed.duration / durations, 1.0),
        tuple(
            each.skill.with_weights(forecast.weights).lasting(each.duration)
            for each, forecast in zip(continuations, forecasts, strict=True)
        ),
        np.array([each.freedom for each in forecasts]),
    )


def _prior(value: ArrayLike | None, size: int) -> Float64Array:
    if value is None:
        return np.full(size, 1.0 / size)
    prior = check.array(value, "prior", shape=(size,))
    if (prior < 0.0).any() or not prior.any():
        raise InvalidInput(f"prior: expected numbers >= 0, not all 0, got {prior}")
    return np.asarray(prior / prior.sum())


def _in_best_mode(
    observed: Motion, skill: ProMPSkill[MotionT], noise: Float64Array
) -> Continuation[MotionT]:
    """The motion under the mode of a skill that it is most probably of."""
    every = [Continuation(observed, mode, noise) for mode in _modes_of(skill)]
    return max(every, key=lambda each: each.evidence)


@lru_cache(maxsize=8)  # with what a skill's demonstrations imply, whatever beginnings come
def _modes_of(skill: ProMPSkill[MotionT]) -> tuple[ProMPSkill[MotionT], ...]:
    """The modes of a skill; instead of those of one demonstration, one of all demonstrations."""
    # One demonstration does not say how its mode varies. Poses of different modes have different
    # reference orientations, and stay apart.
    several = [m for m in skill.modes if m.experience is None or len(m.experience.curves) != 1]
    alike_in_basis = all(each.basis == skill.basis for each in skill.modes)
    if len(several) == len(skill.modes) or skill.coordinates.kind == "poses" or not alike_in_basis:
        return skill.modes
    known = [each.experience for each in skill.modes if each.experience is not None]
    paces = [
        own.paces + np.log(each.duration / skill.duration)
        for each, own in zip(skill.modes, known, strict=True)
    ]
    every = Experience(
        skill.basis,
        np.concatenate([own.curves for own in known]),
        np.concatenate(paces),
        np.mean([own.noise for own in known], axis=0),
        np.max([own.scale for own in known], axis=0),
    )
    return (*several, replace(skill, experience=every))


class Continuation(Generic[MotionT]):
    """A motion that has begun, under one skill."""

    def __init__(self, observed: Motion, skill: ProMPSkill[MotionT], noise: Float64Array) -> None:
        from scipy.special import logsumexp

        chosen = np.unique(np.linspace(0, len(observed.times) - 1, _MAX_SAMPLES).round())
        self._rows = chosen.astype(int)
        self._observed, self.skill, self._noise = observed, skill, noise
        experience = skill.experience
        self._predictive = (
            PosteriorPredictive(skill.free) if experience is None else experience.predictive
        )
        self._nominal = _nominal_pace(experience)
        paces = self._first_paces()
        seen = [self._seen(pace) for pace in paces]
        for _ in range(2):
            paces, seen = self._refined(paces, seen)
        steps = np.gradient(paces) if len(paces) > 1 else np.ones(1)
        evidence, believed = np.array([each.evidence for each in seen]), self._log_prior(paces)
        # The probability of the skill is that of all its durations together.
        self.evidence = float(logsumexp(evidence + believed, b=steps))
        scores = self._log_likelihoods(seen) + believed
        likely = np.exp(scores - scores.max()) * steps
        likely = np.where(likely > _MIN_PROBABILITY * likely.max(), likely, 0.0)
        self._paces, self._likely, self._all = paces, likely / likely.sum(), seen
        self.duration = skill.duration * float(np.exp(self._likely @ paces))

    def forecast(self) -> Forecast:
        """Mean and covariance of the mixture over durations, corrected by left-out forecasts."""
        parts = [each.forecast() for each, p in zip(self._all, self._likely, strict=True) if p > 0]
        likely = self._likely[self._likely > 0.0]
        means = np.stack([each.weights.mean for each in parts])
        mean = likely @ means
        apart = (means - mean) * np.sqrt(likely)[:, None]
        covariance = np.einsum("i,ijk->jk", likely, np.stack([p.weights.covariance for p in parts]))
        heavy = float(likely @ [1.0 / each.freedom for each in parts])
        freedom = 1.0 / heavy if heavy > 0.0 else np.inf
        rest = self._corrected(Gaussian(mean, covariance))
        return Forecast(Gaussian(rest.mean, rest.covariance + apart.T @ apart), freedom)

    def _corrected(self, rest: Gaussian) -> Gaussian:
        """The forecast, at each phase only as far from what was known before as surely gains."""
        from scipy.linalg import block_diag

        experience = self.skill.experience
        end = min(self._observed.duration / self.duration, 1.0)
        if experience is None or end == 1.0:
            return rest
        basis, known = self.skill.basis, self._predictive.known
        ahead = end + (1.0 - end) * _JUDGED
        foreseen = basis(ahead) @ (rest.mean - known.mean).reshape(len(self._noise), -1).T
        followed, scale = self._judged(experience.left_out, end, ahead, foreseen)
        at, judged = prior_phases(basis), np.append(end, ahead)
        left = [1.0 - np.interp(at, judged, np.append(1.0, column)) for column in followed.T]
        back = block_diag(*[multiplied(basis, column) for column in left])
        covariance = rest.covariance + back @ (known.covariance - rest.covariance) @ back.T
        return Gaussian(rest.mean - back @ (rest.mean - known.mean), scale * covariance)

    def _judged(
        self,
        left_out: Sequence[LeftOut],
        end: float,
        ahead: Float64Array,
        deviations: Float64Array,
    ) -> tuple[Float64Array, float]:
        """The fractions (n, d) of deviations to follow at phases, and the covariance's scale."""
        if not left_out:  # nothing says that they come true
            return np.zeros(deviations.shape), 1.0
        phases = np.linspace(0.0, end, min(len(self._rows), _MAX_SAMPLES)), ahead
        spread = float(np.sqrt(self._likely @ (self._paces - self._likely @ self._paces) ** 2))
        judged = [
            [_forecast_of(self._noise, self.skill.basis, each, phases, pace) for each in left_out]
            for pace in np.exp(_OFF_PACE * spread * np.array([0.0, -1.0, 1.0]))
        ]
        on_pace, *off_pace = ([np.array(part) for part in zip(*own, strict=True)] for own in judged)
        # Positions, and the orientations of poses, which have another unit.
        units = [np.split(each, [self.skill.coordinates.size], axis=2) for each in on_pace[:2]]
        kept = np.hstack([_kept(*each) for each in zip(*units, strict=True)])
        foreseen, gained, after, before = map(np.concatenate, zip(*off_pace, strict=True))
        missed, left = gained - kept * foreseen, 1.0 - kept
        lost = left[:, :, None] * left[:, None, :]
        expected = after + lost * (before - after) + np.diag(self._noise)
        squared = (missed * np.linalg.solve(expected, missed[..., None])[..., 0]).sum(axis=2)
        # The mean of a variance after as many squared errors.
        count, error = len(left_out), float(squared.mean()) / len(self._noise)
        scale = (_KNOWN + count * error) / (_KNOWN + count - 2)
        return _followed(kept, deviations, np.abs(on_pace[1]).max(axis=0)), scale

    def _first_paces(self) -> Float64Array:
        """A grid over all durations that can be, finer about the demonstrated ones."""
        least = float(np.log(self._observed.duration / self.skill.duration))
        mean, spread = self._nominal
        paces = np.concatenate([_PACES, mean + spread * _STEPS])
        return np.unique(np.maximum(paces, max(least, _PACES[0])))

    def _refined(self, paces: Float64Array, seen: list[Seen]) -> tuple[Float64Array, list[Seen]]:
        """The grid with more paces between the neighbours of the best one."""
        top = int(np.argmax(self._log_likelihoods(seen) + self._log_prior(paces)))
        first, last = max(top - 1, 0), min(top + 1, len(paces) - 1)
        between = np.linspace(paces[first], paces[last], _REFINED + 2)[1:-1]
        added = between[~np.isin(between, paces)]
        more = [*seen, *(self._seen(pace) for pace in added)]
        order = np.argsort(np.concatenate([paces, added]))
        return np.concatenate([paces, added])[order], [more[i] for i in order]

    def _log_likelihoods(self, seen: Sequence[Seen]) -> Float64Array:
        """Log-likelihoods (n,) of paces, up to a constant, where the noise's size is unknown."""
        count = len(self._rows) * len(self._noise)
        constant = len(self._rows) * np.log(2.0 * np.pi * self._noise).sum()
        squared = -2.0 * np.array([each.evidence for each in seen]) - constant
        # A sample counts once: by another pace, all its columns deviate together.
        return np.asarray(-0.5 * len(self._rows) * np.log1p(np.maximum(squared, 0.0) / count))

    def _log_prior(self, paces: Float64Array) -> Float64Array:
        """Log density (n,) of paces before anything is seen."""
        mean, spread = self._nominal
        nominal = np.exp(-0.5 * ((paces - mean) / spread) ** 2) / spread
        other = np.exp(-0.5 * (paces / _PACE_SPREAD) ** 2) / _PACE_SPREAD
        return np.asarray(np.log((1.0 - _UNUSUAL) * nominal + _UNUSUAL * other))

    def _seen(self, pace: float) -> Seen:
        duration = self.skill.duration * float(np.exp(pace))
        phases = np.minimum((self._observed.times - self._observed.times[0]) / duration, 1.0)
        values = self.skill.coordinates.columns(self._observed, phases, "observed")
        return Seen(
            self._predictive, self.skill.basis, phases[self._rows], values[self._rows], self._noise
        )


def _nominal_pace(experience: Experience | None) -> tuple[float, float]:
    """Mean and standard deviation of the logarithms of durations, over the skill's."""
    if experience is None or len(experience.paces) == 1:
        return 0.0, _PACE_SPREAD
    paces = experience.paces
    squared = float(((paces - paces.mean()) ** 2).sum()) + _MIN_PACE_SPREAD**2
    return float(paces.mean()), float(np.sqrt(squared / len(paces)))


def _forecast_of(
    noise: Float64Array,
    basis: Basis,
    left_out: LeftOut,
    phases: tuple[Float64Array, Float64Array],
    pace: float,
) -> tuple[Float64Array, Float64Array, Float64Array, Float64Array]:
    """Deviations (n, d) of a left-out curve, foreseen and true; covariances after and before."""
    (curve, predictive), (seen, ahead) = left_out, phases
    columns, known = curve.reshape(len(noise), -1).T, predictive.known
    values = basis(np.minimum(pace * seen, 1.0)) @ columns
    rest = Seen(predictive, basis, seen, values, noise).forecast().weights
    rows = basis(ahead)
    nominal, found = (rows @ each.reshape(len(noise), -1).T for each in (known.mean, rest.mean))
    gained = basis(np.minimum(pace * ahead, 1.0)) @ columns - nominal
    after, before = (each.columns_at(rows)[1] for each in (rest, known))
    return found - nominal, gained, after, before


def _followed(kept: Float64Array, deviations: Float64Array, most: Float64Array) -> Float64Array:
    """The fractions (n, d) to follow: those that come true, of no more than `most` (n, d)."""
    near = np.clip(kept * deviations, -most, most)
    return np.divide(near, deviations, out=np.zeros_like(near), where=deviations != 0.0)


def _kept(foreseen: Float64Array, gained: Float64Array) -> Float64Array:
    """Fractions (n, d) in [0, 1] of deviations (m, n, d) that come true, half by phase."""
    smallest = np.finfo(np.float64).tiny
    # In units of the deviations at each phase, or the first phases, the widest, would decide.
    unit = np.maximum((gained**2).sum(axis=(0, 2)), smallest)
    product, squared = ((foreseen * each).sum(axis=(0, 2)) / unit for each in (gained, foreseen))
    own = product / np.maximum(squared, smallest)
    every = product.sum() / max(squared.sum(), smallest)
    # Two may deviate alike by chance: one of all pairs does not count.
    by_chance = 2.0 / (len(foreseen) * (len(foreseen) - 1))
    kept = (0.5 - 0.5 * by_chance) * (np.clip(own, 0.0, 1.0) + np.clip(every, 0.0, 1.0))
    return np.repeat(kept[:, None], foreseen.shape[2], axis=1)


@dataclass(frozen=True, eq=False)
class Forecast(ShortRepr):
    """Distribution of the weights of a motion that has been seen in part."""

    weights: Gaussian  # mean and covariance of the weights (d k,)
    freedom: float  # degrees of freedom, > 4, of the t distribution with these moments


class Seen:
    """Samples of a motion at supposed phases, under a predictive about its weights."""

    def __init__(
        self,
        predictive: PosteriorPredictive,
        basis: Basis,
        phases: Float64Array,
        values: Float64Array,
        noise: Float64Array,
    ) -> None:
        self._predictive = predictive
        size, rows, root = len(noise), basis(phases), predictive.spread.root
        residual = (values - rows @ predictive.spread.mean.reshape(size, -1).T) / np.sqrt(noise)
        # Few functions reach far into the part that was seen: as few rows hold what is known.
        across, lengths, along = np.linalg.svd(rows, full_matrices=False)
        informative = lengths > 1e-9 * lengths[0]
        few = lengths[informative, None] * along[informative]
        blocks = root.reshape(size, basis.count, -1) / np.sqrt(noise)[:, None, None]
        self._reached = np.matmul(few, blocks).reshape(-1, root.shape[1])
        # In the coordinates z, weights = mean + root reached.T axes z, each is observed on its own.
        precisions, axes = np.linalg.eigh(self._reached @ self._reached.T)
        seen = precisions > _UNSEEN * precisions[-1]
        self._precisions, self._axes = precisions[seen], axes[:, seen]
        pulled = self._axes.T @ (across[:, informative].T @ residual).T.ravel()
        self._pulled = pulled * np.sqrt(self._precisions)
        self._factors, believed = _log_prior(predictive.freedom)
        # Variance (factors, z) of each z after the samples.
        self._variances = 1.0 / (1.0 / self._factors[:, None] + self._precisions)
        gained = self._variances @ self._pulled**2
        volume = np.log1p(self._factors[:, None] * self._precisions).sum(axis=1)
        scores = believed + 0.5 * (gained - volume)
        likely = np.exp(scores - scores.max())
        constant = (residual**2).sum() + len(values) * np.log(2.0 * np.pi * noise).sum()
        self.evidence = float(scores.max() + np.log(likely.sum()) - 0.5 * constant)
        self._likely = likely / likely.sum()

    def forecast(self) -> Forecast:
        """The distribution of the weights, its first two moments those of the mixture."""
        factor = float(self._likely @ self._factors)
        gain = self._likely @ self._variances
        varied = (self._variances - gain) * self._pulled
        root = self._predictive.spread.root
        seen = root @ (self._reached.T @ (self._axes / np.sqrt(self._precisions)))
        within = np.diag(gain - factor) + (varied.T * self._likely) @ varied
        covariance = factor * (root @ root.T) + seen @ within @ seen.T
        mean = self._predictive.spread.mean + seen @ (gain * self._pulled)
        return Forecast(Gaussian(mean, 0.5 * (covariance + covariance.T)), self._freedom(factor))

    def _freedom(self, factor: float) -> float:
        """Of the inverse gamma distribution with the factor's mean and variance."""
        variance = float(self._likely @ (self._factors - factor) ** 2)
        return 4.0 + 2.0 * factor**2 / variance if variance > 0.0 else np.inf


@lru_cache(maxsize=64)  # every pace that is tried asks for those of the same skill
def _log_prior(freedom: float) -> tuple[Float64Array, Float64Array]:
    """Factors (n,) of the covariance, and the logs of their prior probabilities."""
    from scipy.special import logsumexp

    if np.isinf(freedom):
        return np.ones(1), np.zeros(1)
    log_density = -0.5 * freedom * (_FACTORS + np.exp(-_FACTORS) - 1.0)
    return np.exp(_FACTORS), log_density - logsumexp(log_density)
