"""Which motion has begun, how fast it goes and how it will go on, from its first samples.

Source: Maeda et al. 2017, "Phase estimation for fast action recognition and trajectory generation
in human-robot collaboration".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.promp import observation
from leadthrough.models.promp.alike import check_alike
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.motion import Motion, MotionT, MotionT_co

# More samples add nothing: neighbours are not independent.
_MOST_SAMPLES = 50
# Durations that are tried, relative to the skill's.
_PACES = np.geomspace(0.4, 2.5, 37)
# A motion's deviation from a skill is not white noise: neighbouring samples deviate alike. So
# deviations up to this fraction of the reach do not count against a skill; nor does it count
# against one that its demonstrations were less precise than another's.
_FORGIVEN = 0.03
# Standard deviation of the logarithm of people's durations.
_PACE_SPREAD = 0.25


@dataclass(frozen=True, eq=False)
class Inference(Generic[MotionT_co]):
    """What the beginning of a motion tells; entry i is about skill i.

    Attributes:
        probabilities: probability (k,) of each skill.
        durations: the most likely duration (k,) of the whole motion under each skill, s.
        phases: the phase (k,) at which the observed part ends, in (0, 1].
        skills: the k skills conditioned on the observed part, with the new durations.
    """

    probabilities: Float64Array
    durations: Float64Array
    phases: Float64Array
    skills: tuple[ProMPSkill[MotionT_co], ...]

    @property
    def best(self) -> int:
        """Index of the most probable skill."""
        return int(np.argmax(self.probabilities))


def infer(
    observed: Motion, skills: Sequence[ProMPSkill[MotionT]], *, prior: ArrayLike | None = None
) -> Inference[MotionT]:
    """Probability, duration and continuation of a motion under each of several skills.

    The probabilities treat the skills' distributions as known: with a dozen demonstrations per
    skill or fewer they come out too close to 0 and 1.

    Args:
        observed: first part of a motion, from its start on, at least two samples, of the skills'
            type.
        skills: k skills of one motion type.
        prior: probabilities (k,) before anything is observed, >= 0; by default equal.

    Raises:
        InvalidInput: if the motion has fewer than two samples or another type, if the skills
            differ in type, or if the prior is negative or all 0.
    """
    check_alike(skills)
    observation.check_seen(observed, "observed")
    before = _prior(prior, len(skills))
    noise = _common_noise(skills)
    found = [_Pace(observed, skill, noise) for skill in skills]
    with np.errstate(divide="ignore"):
        evidence = np.log(before) + [pace.evidence for pace in found]
    probabilities = np.exp(evidence - evidence.max())
    durations = np.array([pace.duration for pace in found])
    return Inference(
        probabilities / probabilities.sum(),
        durations,
        observed.duration / durations,
        tuple(pace.conditioned() for pace in found),
    )


class _Pace(Generic[MotionT_co]):
    """The most likely duration of a partly observed motion under a skill."""

    def __init__(
        self, observed: Motion, skill: ProMPSkill[MotionT_co], noise: Float64Array
    ) -> None:
        chosen = np.unique(np.linspace(0, len(observed.times) - 1, _MOST_SAMPLES).round())
        self._rows = chosen.astype(int)
        self._observed, self._skill = observed, skill
        self._judged = replace(skill, noise=noise)
        least = max(np.log(observed.duration / skill.duration), np.log(_PACES[0]))
        paces = np.unique(np.maximum(np.log(_PACES), least))
        scores = np.array([self._score(pace) for pace in paces])
        self.duration = skill.duration * float(np.exp(self._refined(paces, scores)))
        # The probability of the skill is that of all its durations together.
        steps = np.gradient(paces) if len(paces) > 1 else np.ones(1)
        best = float(scores.max())
        self.evidence = best + float(np.log((np.exp(scores - best) * steps).sum()))

    def conditioned(self) -> ProMPSkill[MotionT_co]:
        """The skill conditioned on the observed part, with the most likely duration."""
        phases, values = self._seen(self.duration)
        return observation.along(self._skill, phases, values).lasting(self.duration)

    def _refined(self, paces: Float64Array, scores: Float64Array) -> float:
        """The best pace, searched between the neighbours of the best one of a grid."""
        top = int(scores.argmax())
        around = paces[max(top - 1, 0)], paces[min(top + 1, len(paces) - 1)]
        pace = float(paces[top])
        if around[0] < around[1]:
            found = minimize_scalar(lambda x: -self._score(x), bounds=around, method="bounded")
            pace = pace if -found.fun < scores[top] else float(found.x)
        return pace

    def _score(self, pace: float) -> float:
        """Log density of the observed part at a pace, the log of the duration's ratio."""
        duration = self._skill.duration * float(np.exp(pace))
        believed = -0.5 * (pace / _PACE_SPREAD) ** 2
        return believed + observation.log_density(self._judged, *self._seen(duration))

    def _seen(self, duration: float) -> tuple[Float64Array, Float64Array]:
        phases = np.minimum((self._observed.times - self._observed.times[0]) / duration, 1.0)
        values = self._skill.chart.columns(self._observed, phases, "observed")
        return phases[self._rows], values[self._rows]


def _common_noise(skills: Sequence[ProMPSkill]) -> Float64Array:
    """Variances (d,) of deviations that do not count against any of the skills."""
    noise = np.mean([each.noise for each in skills], axis=0)
    reach = np.mean([each.scale for each in skills], axis=0)
    return np.asarray(noise + (_FORGIVEN * reach) ** 2)


def _prior(value: ArrayLike | None, size: int) -> Float64Array:
    if value is None:
        return np.full(size, 1.0 / size)
    prior = check.array(value, "prior", shape=(size,))
    if (prior < 0.0).any() or not prior.any():
        raise InvalidInput(f"prior: expected numbers >= 0, not all 0, got {prior}")
    return np.asarray(prior / prior.sum())
