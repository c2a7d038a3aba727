"""Which motion an observer sees the beginning of, how fast it goes, and how it will go on.

Source: Maeda et al. 2017, "Phase estimation for fast action recognition and trajectory generation
in human-robot collaboration".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.promp import observation
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.motion import Motion

# More samples say the same again: neighbours are not independent.
_MOST_SAMPLES = 50
# Durations that are tried, in shares of the skill's.
_PACES = np.geomspace(0.4, 2.5, 37)
# What a motion deviates from a skill by is not white noise: neighbouring samples deviate alike. So
# deviations up to this share of the reach are not held against a skill, nor is it held against one
# that it was shown less precisely than another.
_FORGIVEN = 0.03
# Standard deviation of the logarithm of people's durations.
_PACE_SPREAD = 0.25


@dataclass(frozen=True, eq=False)
class Inference:
    """What the beginning of a motion tells; entry i is about skill i.

    probabilities: (k,). durations: (k,) s, of the whole motion. phases: (k,) where it stands, in
    (0, 1]. skills: conditioned on what was seen, with the new durations.
    """

    probabilities: Float64Array
    durations: Float64Array
    phases: Float64Array
    skills: tuple[ProMPSkill, ...]

    @property
    def best(self) -> int:
        """The most probable skill."""
        return int(np.argmax(self.probabilities))


def infer(observed: Motion, skills: Sequence[ProMPSkill], *, prior: Any = None) -> Inference:
    """The motion that goes on, from its first part, which starts where the motion starts.

    observed: at least two samples, of the skills' type. prior: (k,) probabilities before, by
    default equal. The probabilities take the skills' distributions as known: of skills from a dozen
    demonstrations or fewer they are too sure. Raises InvalidInput.
    """
    if not isinstance(skills, Sequence) or len(skills) == 0:
        raise InvalidInput("skills: expected at least one")
    if not isinstance(observed, Motion) or len(observed.times) < 2:
        raise InvalidInput("observed: expected a motion of at least two samples")
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


class _Pace:
    """The most likely duration of a motion seen in part, if it is a skill's."""

    def __init__(self, observed: Motion, skill: ProMPSkill, noise: Float64Array) -> None:
        chosen = np.unique(np.linspace(0, len(observed.times) - 1, _MOST_SAMPLES).round())
        self._rows = chosen.astype(int)
        self._observed, self._skill = observed, skill
        self._judged = replace(skill, noise=noise)
        least = max(np.log(observed.duration / skill.duration), np.log(_PACES[0]))
        paces = np.unique(np.maximum(np.log(_PACES), least))
        scores = np.array([self._score(pace) for pace in paces])
        top = int(scores.argmax())
        around = paces[max(top - 1, 0)], paces[min(top + 1, len(paces) - 1)]
        pace = float(paces[top])
        if around[0] < around[1]:
            found = minimize_scalar(lambda x: -self._score(x), bounds=around, method="bounded")
            pace = pace if -found.fun < scores[top] else float(found.x)
        self.duration = skill.duration * float(np.exp(pace))
        # The probability of the skill is that of all its durations together.
        steps = np.gradient(paces) if len(paces) > 1 else np.ones(1)
        best = float(scores.max())
        self.evidence = best + float(np.log((np.exp(scores - best) * steps).sum()))

    def conditioned(self) -> ProMPSkill:
        phases, values = self._seen(self.duration)
        return observation.along(self._skill, phases, values).lasting(self.duration)

    def _score(self, pace: float) -> float:
        duration = self._skill.duration * float(np.exp(pace))
        believed = -0.5 * (pace / _PACE_SPREAD) ** 2
        return believed + observation.log_density(self._judged, *self._seen(duration))

    def _seen(self, duration: float) -> tuple[Float64Array, Float64Array]:
        phases = np.minimum((self._observed.times - self._observed.times[0]) / duration, 1.0)
        values = self._skill.chart.columns(self._observed, phases, "observed")
        return phases[self._rows], values[self._rows]


def _common_noise(skills: Sequence[ProMPSkill]) -> Float64Array:
    """Variances (d,) of what is not held against any of the skills."""
    for each in skills:
        if not isinstance(each, ProMPSkill):
            raise InvalidInput(f"skills: expected ProMPSkill, got {type(each).__name__}")
    if len({(each.chart.kind, each.chart.size) for each in skills}) > 1:
        raise InvalidInput("skills: expected all of the same points, joints or poses")
    noise = np.mean([each.noise for each in skills], axis=0)
    reach = np.mean([each.scale for each in skills], axis=0)
    return np.asarray(noise + (_FORGIVEN * reach) ** 2)


def _prior(value: Any, size: int) -> Float64Array:
    if value is None:
        return np.full(size, 1.0 / size)
    prior = check.array(value, "prior", shape=(size,))
    if (prior < 0.0).any() or not prior.any():
        raise InvalidInput(f"prior: expected numbers >= 0, not all 0, got {prior}")
    return np.asarray(prior / prior.sum())
