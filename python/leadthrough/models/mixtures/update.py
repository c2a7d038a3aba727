"""A Gaussian mixture that learns further demonstrations without the old ones.

The old mixture stands for the sums of the points that it was fitted to.

Source: Calinon and Billard 2007, "Incremental learning of gestures by imitation in a humanoid
robot", direct method.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.mixtures.em import Blocks, Steps, sums_of
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.samples import timed_columns
from leadthrough.models.mixtures.units import Units, of_poses
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
    units = _units(skill.mixture, poses=skill.chart.kind == "poses")
    before = len(points) / len(motions) * skill.demonstration_count
    mixture = _adapted(skill.mixture, points, before, units)
    ends = np.sum([each[[0, -1], 1:] for each in samples], axis=0)
    return mixture, (skill.ends * skill.demonstration_count + ends) / total, total


def _adapted(mixture: Mixture, points: Float64Array, before: float, units: Units) -> Mixture:
    """The mixture of new points (n, d) and of the `before` old ones that it stands for."""
    scale = units.scale
    covariances = mixture.covariances / (scale * scale[:, None])
    old = Blocks(mixture.weights, (units.scaled(mixture.means),), (covariances,))
    steps = Steps([units.scaled(points)], sums_of(old, before), least=units.least)
    new, _ = steps.run(old, _MOST_ITERATIONS)
    return Mixture(new.weights, units.means(new.means[0]), units.covariances(new.covariances[0]))


def _units(mixture: Mixture, *, poses: bool) -> Units:
    """Units of the points that a mixture stands for.

    Where a mixture is thinner than the least variance of poses, as those in files of earlier
    versions are, it may stay so: EM would undo each step that makes it less likely.
    """
    middle = mixture.weights @ mixture.means
    variances = np.einsum("kii->ki", mixture.covariances) + (mixture.means - middle) ** 2
    own = Units(middle, np.sqrt(mixture.weights @ variances))
    if not poses:
        return own
    units = of_poses(own)
    scaled = mixture.covariances / units.scale / units.scale[:, None]
    return replace(units, least=min(units.least, float(np.linalg.eigvalsh(scaled).min())))
