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
from leadthrough.models.gaussians.em import LEAST_VARIANCE, Blocks, Steps, bounded, sums_of
from leadthrough.models.gaussians.mixture import Mixture
from leadthrough.models.gaussians.units import Units, phase_units
from leadthrough.models.mixtures.phases import WIDE, thinner
from leadthrough.models.mixtures.samples import timed_columns
from leadthrough.motion import Motion, normalised_times

if TYPE_CHECKING:
    from leadthrough.models.mixtures.gmr_skill import GMRSkill

_MOST_ITERATIONS = 200


def learned(
    skill: GMRSkill, demonstrations: Demonstrations[Motion]
) -> tuple[Mixture, Float64Array, int]:
    """What a skill becomes with further demonstrations."""
    motions = motions_of(demonstrations)
    phases = [normalised_times(motion.times) for motion in motions]
    samples = timed_columns(motions, phases, skill.chart, skill.duration)
    total = skill.demonstration_count + len(motions)
    points = np.concatenate(samples)
    before = len(points) / len(motions) * skill.demonstration_count
    mixture = _adapted(skill.mixture, points, before, poses=skill.chart.kind == "poses")
    ends = np.sum([each[[0, -1], 1:] for each in samples], axis=0)
    return mixture, (skill.ends * skill.demonstration_count + ends) / total, total


def _adapted(mixture: Mixture, points: Float64Array, before: float, *, poses: bool) -> Mixture:
    """The mixture of new points (n, d) and of the `before` old ones that it stands for."""
    units = _units(mixture, poses=poses)
    covariances = units.scaled_covariances(mixture.covariances)
    old = Blocks(mixture.weights, (units.scaled(mixture.means),), (covariances,))
    blocks, sums = [units.scaled(points)], sums_of(old, before)
    steps = Steps(blocks, sums, least=WIDE)
    wide = replace(old, covariances=(bounded(covariances, WIDE),))
    found, _ = steps.run(wide, _MOST_ITERATIONS)
    new, _ = thinner(found, steps, LEAST_VARIANCE)
    return Mixture(new.weights, units.means(new.means[0]), units.covariances(new.covariances[0]))


def _units(mixture: Mixture, *, poses: bool) -> Units:
    """Units of the points that a mixture stands for."""
    middle = mixture.weights @ mixture.means
    variances = np.einsum("kii->ki", mixture.covariances) + (mixture.means - middle) ** 2
    own = Units(middle, np.sqrt(mixture.weights @ variances))
    return phase_units(own, mixture.count, poses=poses)
