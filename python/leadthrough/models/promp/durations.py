"""How a motion that has begun goes on, whatever its duration: a mixture over the durations."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.promp.belief import Belief, Experience
from leadthrough.models.promp.forecast import Forecast, Seen
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.motion import Motion

# More samples add nothing: neighbours are not independent.
_MOST_SAMPLES = 50
# Logarithms of durations that are tried, over the skill's.
_PACES = np.log(np.geomspace(0.4, 2.5, 37))
# People's durations: standard deviation of the logarithm where nothing is known, and the
# fraction of motions that go at another pace than the demonstrations.
_PACE_SPREAD = 0.25
_UNUSUAL = 0.1
# The power of what the samples tell of the duration: their deviations are not independent.
_TEMPERED = 0.3
# Demonstrations of one duration: the least standard deviation, which counts as one of them.
_LEAST_PACE_SPREAD = 0.03
_STEPS = np.linspace(-3.0, 3.0, 13)  # paces tried about the demonstrated ones, in deviations
_REFINED = 9  # paces tried between the best one's neighbours, twice
# Durations less probable than this, relative to the best one, are left out of the mixture.
_LEAST_PROBABILITY = 1e-3
# Where left-out forecasts are judged, as fractions of the part that was not seen.
_JUDGED = np.array([0.4, 0.7, 1.0])


class Continuation:
    """A motion that has begun, under one skill."""

    def __init__(self, observed: Motion, skill: ProMPSkill, noise: Float64Array) -> None:
        from scipy.special import logsumexp

        chosen = np.unique(np.linspace(0, len(observed.times) - 1, _MOST_SAMPLES).round())
        self._rows = chosen.astype(int)
        self._observed, self._skill, self._noise = observed, skill, noise
        experience = skill.experience
        self._belief = Belief(skill.free) if experience is None else experience.belief
        self._usual = _usual_pace(experience)
        paces = self._first_paces()
        seen = [self._seen(pace) for pace in paces]
        for _ in range(2):
            paces, seen = self._refined(paces, seen)
        steps = np.gradient(paces) if len(paces) > 1 else np.ones(1)
        told, believed = np.array([each.evidence for each in seen]), self._believed(paces)
        # The probability of the skill is that of all its durations together.
        self.evidence = float(logsumexp(told + believed, b=steps))
        scores = _TEMPERED * told + believed
        likely = np.exp(scores - scores.max()) * steps
        likely = np.where(likely > _LEAST_PROBABILITY * likely.max(), likely, 0.0)
        self._paces, self._likely, self._all = paces, likely / likely.sum(), seen
        self.duration = skill.duration * float(np.exp(self._likely @ paces))

    def forecast(self) -> Forecast:
        """Mean and covariance of the mixture over the durations, with the scale corrected."""
        parts = [each.forecast() for each, p in zip(self._all, self._likely, strict=True) if p > 0]
        likely = self._likely[self._likely > 0.0]
        means = np.stack([each.weights.mean for each in parts])
        mean = likely @ means
        apart = (means - mean) * np.sqrt(likely)[:, None]
        covariance = self._correction() * np.einsum(
            "i,ijk->jk", likely, np.stack([each.weights.covariance for each in parts])
        )
        heavy = float(likely @ [1.0 / each.freedom for each in parts])
        freedom = 1.0 / heavy if heavy > 0.0 else np.inf
        return Forecast(Gaussian(mean, covariance + apart.T @ apart), freedom)

    def _correction(self) -> float:
        """How far left-out demonstrations, seen as far, were off, in variances of the forecast."""
        experience = self._skill.experience
        end = min(self._observed.duration / self.duration, 1.0)
        if experience is None or end == 1.0 or not experience.left_out:
            return 1.0
        basis, size = self._skill.basis, len(self._noise)
        phases = np.linspace(0.0, end, min(len(self._rows), _MOST_SAMPLES))
        ahead = basis(end + (1.0 - end) * _JUDGED)
        rows = basis(phases)
        off = []
        for curve, belief in experience.left_out:
            values = rows @ curve.reshape(size, -1).T
            found = Seen(belief, basis, phases, values, self._noise).forecast().weights
            off.append(_squared_error(curve - found.mean, found.covariance, ahead, self._noise))
        # The mean of a variance after as many squared errors, if nothing was known before.
        return float(np.sum(off) / (len(off) - 2))

    def _first_paces(self) -> Float64Array:
        """A grid over all durations that can be, finer about the demonstrated ones."""
        least = float(np.log(self._observed.duration / self._skill.duration))
        mean, spread = self._usual
        paces = np.concatenate([_PACES, mean + spread * _STEPS])
        return np.unique(np.maximum(paces, max(least, _PACES[0])))

    def _refined(self, paces: Float64Array, seen: list[Seen]) -> tuple[Float64Array, list[Seen]]:
        """The grid with more paces between the neighbours of the best one."""
        told = _TEMPERED * np.array([each.evidence for each in seen])
        top = int(np.argmax(told + self._believed(paces)))
        first, last = max(top - 1, 0), min(top + 1, len(paces) - 1)
        between = np.linspace(paces[first], paces[last], _REFINED + 2)[1:-1]
        added = between[~np.isin(between, paces)]
        more = [*seen, *(self._seen(pace) for pace in added)]
        order = np.argsort(np.concatenate([paces, added]))
        return np.concatenate([paces, added])[order], [more[i] for i in order]

    def _believed(self, paces: Float64Array) -> Float64Array:
        """Log density (n,) of paces before anything is seen."""
        mean, spread = self._usual
        usual = np.exp(-0.5 * ((paces - mean) / spread) ** 2) / spread
        other = np.exp(-0.5 * (paces / _PACE_SPREAD) ** 2) / _PACE_SPREAD
        return np.asarray(np.log((1.0 - _UNUSUAL) * usual + _UNUSUAL * other))

    def _seen(self, pace: float) -> Seen:
        duration = self._skill.duration * float(np.exp(pace))
        phases = np.minimum((self._observed.times - self._observed.times[0]) / duration, 1.0)
        values = self._skill.chart.columns(self._observed, phases, "observed")
        return Seen(
            self._belief, self._skill.basis, phases[self._rows], values[self._rows], self._noise
        )


def _usual_pace(experience: Experience | None) -> tuple[float, float]:
    """Mean and standard deviation of the logarithms of durations, over the skill's."""
    if experience is None or len(experience.paces) == 1:
        return 0.0, _PACE_SPREAD
    paces = experience.paces
    squared = float(((paces - paces.mean()) ** 2).sum()) + _LEAST_PACE_SPREAD**2
    return float(paces.mean()), float(np.sqrt(squared / len(paces)))


def _squared_error(
    missed: Float64Array, covariance: Float64Array, rows: Float64Array, noise: Float64Array
) -> float:
    """Mean squared error of curves at phases, per column, in variances of the forecast."""
    size = len(noise)
    errors = rows @ missed.reshape(size, -1).T
    blocks = covariance.reshape(size, rows.shape[1], size, rows.shape[1])
    spread = np.einsum("nk,ikjl,nl->nij", rows, blocks, rows) + np.diag(noise)
    squared = errors * np.linalg.solve(spread, errors[:, :, None])[:, :, 0]
    return float(squared.sum() / errors.size)
