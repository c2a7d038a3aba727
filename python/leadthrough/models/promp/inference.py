"""Which motion has begun, how fast it goes and how it will go on, from its first samples.

The weights of a motion have a t distribution (`belief`), whose scale the left-out demonstrations
correct; its duration is uncertain too. What comes out is a mixture over the durations.

Sources: Maeda et al. 2017, "Phase estimation for fast action recognition and trajectory generation
in human-robot collaboration"; Murphy 2012, "Machine learning: a probabilistic perspective",
section 4.6.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.promp import observation
from leadthrough.models.promp.alike import check_alike
from leadthrough.models.promp.belief import common_noise
from leadthrough.models.promp.durations import Continuation
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.motion import Motion, MotionT, MotionT_co
from leadthrough.repr import ShortRepr


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
            columns: points (n, d); for poses as `Chart.columns` gives them.

        Raises:
            InvalidInput: if there is not one point per ellipsoid.
        """
        away = check.array(columns, "columns", shape=self.mean.shape) - self.mean
        solved = np.linalg.solve(self.shape, away[:, :, None])[:, :, 0]
        return np.asarray((away * solved).sum(axis=1) <= 1.0)


@dataclass(frozen=True, eq=False)
class Inference(ShortRepr, Generic[MotionT_co]):
    """What the beginning of a motion tells; entry i is about skill i.

    Attributes:
        probabilities: probability (k,) of each skill.
        durations: the expected duration (k,) of the whole motion under each skill, s.
        phases: the phase (k,) at which the observed part ends, in (0, 1].
        skills: the k skills conditioned on the observed part, with the new durations. Their
            `distribution` is the mean and the covariance of the forecast, whose uncertainty
            includes that the demonstrations tell mean, covariance and duration only so well.
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
        """Where the motion is expected to be, its samples as noisy as the demonstrations.

        The ellipsoids hold the motion with this probability at each time on its own, not at all
        times at once. They are those of a t distribution with `freedom` degrees of freedom and
        the moments that the skill's `distribution` gives.

        Args:
            times: times (n,) since the start of the motion, s, in [0, duration].
            skill: index of the skill; by default the most probable one.
            probability: probability that a region holds, in (0, 1).

        Raises:
            InvalidInput: if an argument is out of range.
        """
        check.number(probability, "probability", above=0.0, below=1.0)
        chosen = self.best if skill is None else skill
        check.integer(chosen, "skill", at_least=0, at_most=len(self.skills) - 1)
        mean, covariance = self.skills[chosen].distribution(times)
        covariance = covariance + np.diag(self.skills[chosen].noise)
        return Region(mean, covariance * self._radius(mean.shape[1], chosen, probability))

    def _radius(self, size: int, skill: int, probability: float) -> float:
        """Squared Mahalanobis distance, by the covariance, at which a region ends."""
        from scipy.stats import chi2
        from scipy.stats import f as fisher

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
        skills: k skills of one motion type.
        prior: probabilities (k,) before anything is observed, >= 0; by default equal.

    Raises:
        InvalidInput: if the motion has fewer than two samples or another type, if the skills
            differ in type, or if the prior is negative or all 0.
    """
    check_alike(skills)
    observation.check_seen(observed, "observed")
    before = _prior(prior, len(skills))
    noise = common_noise([each.noise for each in skills], [each.scale for each in skills])
    found = [Continuation(observed, skill, noise) for skill in skills]
    with np.errstate(divide="ignore"):
        evidence = np.log(before) + [each.evidence for each in found]
    probabilities = np.exp(evidence - evidence.max())
    durations = np.array([each.duration for each in found])
    forecasts = [each.forecast() for each in found]
    return Inference(
        probabilities / probabilities.sum(),
        durations,
        np.minimum(observed.duration / durations, 1.0),
        tuple(
            skill.with_weights(forecast.weights).lasting(float(duration))
            for skill, forecast, duration in zip(skills, forecasts, durations, strict=True)
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
