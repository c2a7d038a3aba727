"""A Gaussian mixture that learns further demonstrations without the old ones.

The old mixture stands for the sums of the points that it was fitted to.

Source: Calinon and Billard 2007, "Incremental learning of gestures by imitation in a humanoid
robot", direct method.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.mixtures.em import Blocks, Steps, sums_of
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.samples import timed_columns
from leadthrough.motion import Motion, normalised_times

if TYPE_CHECKING:
    from leadthrough.models.mixtures.gmr_skill import GMRSkill

_MOST_ITERATIONS = 200


def learned(
    skill: GMRSkill, demonstrations: Demonstrations[Motion]
) -> tuple[Mixture, Float64Array, int]:
    """What a skill becomes with further demonstrations.

    Args:
        skill: the skill before.
        demonstrations: one or more demonstrations of the skill's type of motion.

    Returns:
        The mixture, the mean start and goal (2, d), and the number of demonstrations.

    Raises:
        InvalidInput: if the demonstrations are of another type.
        FitError: if there is none, or one does not move.
    """
    motions = motions_of(demonstrations)
    phases = [normalised_times(motion.times) for motion in motions]
    samples = timed_columns(motions, phases, skill.chart, skill.duration)
    total = skill.demonstration_count + len(motions)
    points = np.concatenate(samples)
    mixture = _adapted(
        skill.mixture, points, len(points) / len(motions) * skill.demonstration_count
    )
    ends = np.sum([each[[0, -1], 1:] for each in samples], axis=0)
    return mixture, (skill.ends * skill.demonstration_count + ends) / total, total


def _adapted(mixture: Mixture, points: Float64Array, before: float) -> Mixture:
    """The mixture of new points (n, d) and of the `before` old ones that it stands for."""
    middle, scale = _moments(mixture)
    old = Blocks(
        mixture.weights,
        ((mixture.means - middle) / scale,),
        (mixture.covariances / (scale * scale[:, None]),),
    )
    steps = Steps([(points - middle) / scale], sums_of(old, before))
    new, _ = steps.run(old, _MOST_ITERATIONS)
    return Mixture(
        new.weights, new.means[0] * scale + middle, new.covariances[0] * scale * scale[:, None]
    )


def _moments(mixture: Mixture) -> tuple[Float64Array, Float64Array]:
    """Means and standard deviations (d,) of the points that a mixture stands for."""
    middle = mixture.weights @ mixture.means
    variances = np.einsum("kii->ki", mixture.covariances) + (mixture.means - middle) ** 2
    return middle, np.sqrt(mixture.weights @ variances)
