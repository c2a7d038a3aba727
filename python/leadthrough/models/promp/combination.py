"""Several ProMPs combined into one motion, at once or one after the other.

Source: Paraschos et al. 2018, "Using probabilistic movement primitives in robotics", eqs. 12 to 14.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.coordinates import NODES, Coordinates, carried
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.model import ProMPSkill
from leadthrough.motion import MotionT, normalised_times

# Standard deviation added where a skill has none, as a fraction of the motion's reach: the
# covariance is inverted.
_MIN_DEVIATION = 1e-7
# Rotation vectors farther from a reference, rad, are no longer nearly a linear space.
_MAX_ROTATION = 0.5 * np.pi


def combine(
    skills: Sequence[ProMPSkill[MotionT]], *, activations: ArrayLike | None = None
) -> ProMPSkill[MotionT]:
    """The motions that all skills find likely at once: the product of their distributions.

    Args:
        skills: k skills of the same type of motion, with equal bases; joints in any order, the
            first one's counts. Orientations of poses must lie within a right angle of each other.
        activations: powers (k,) of the factors, > 0; by default all 1.

    Returns:
        A skill with the duration, the noise, the limits and, for poses, the reference orientation
        of the first one.

    Raises:
        InvalidInput: if the skills differ in type or basis, if orientations are more than a right
            angle apart, or if an activation is not positive.
    """
    skills = alike(skills)
    skills = [_about(each, skills[0].coordinates) for each in skills]
    if len({each.basis for each in skills}) > 1:
        raise InvalidInput(
            "skills: expected the same basis, width and number of weights in all; "
            "fit them with the same ProMP"
        )
    given = np.ones(len(skills)) if activations is None else activations
    powers = check.array(given, "activations", shape=(len(skills),))
    if not (powers > 0.0).all():
        raise InvalidInput(f"activations: expected numbers > 0, got {powers}")
    weights = product([each.free for each in skills], [float(power) for power in powers])
    return skills[0].with_weights(weights)


def blend(
    skills: Sequence[ProMPSkill], times: ArrayLike, activations: ArrayLike
) -> tuple[Float64Array, Float64Array]:
    """Mean and covariance of a motion that passes from one skill to the next.

    Args:
        skills: k skills of the same type of motion; joints in any order, the first one's counts.
            Each runs over the whole motion, whatever its own duration. Orientations of poses must
            lie within a right angle of each other.
        times: times (n,) of the whole motion, s, increasing.
        activations: activation (n, k) of each skill at each time, >= 0, not all 0 at any time.

    Returns:
        Mean (n, d) and covariance (n, d, d). For poses, the columns are those of
        `skills[0].coordinates`, whose `motion` turns them into a trajectory.

    Raises:
        InvalidInput: if the skills differ in type, if orientations are more than a right angle
            apart, or if the times or the activations are not as described.
    """
    skills = alike(skills)
    skills = [_about(each, skills[0].coordinates) for each in skills]
    at = check.times(times, "times")
    active = check.array(activations, "activations", shape=(len(at), len(skills)))
    if (active < 0.0).any() or (active.sum(axis=1) == 0.0).any():
        row = int(np.argmax((active < 0.0).any(axis=1) | (active.sum(axis=1) == 0.0)))
        raise check.refused(
            "activations", "numbers >= 0, not all 0 at any time", f"{active[row]} at sample {row}"
        )
    phases = normalised_times(at)
    precision, pull = 0.0, 0.0
    for each, activation in zip(skills, active.T, strict=True):
        mean, covariance = each.distribution(phases * each.duration)
        inverse = np.linalg.inv(covariance + np.diag((_MIN_DEVIATION * each.scale) ** 2))
        weighted = inverse * activation[:, None, None]
        precision = precision + weighted
        pull = pull + weighted @ mean[:, :, None]
    blended = np.linalg.inv(precision)
    mean = (blended @ pull)[:, :, 0]
    return mean, 0.5 * (blended + blended.transpose(0, 2, 1))


def product(factors: Sequence[Gaussian], powers: Sequence[float]) -> Gaussian:
    """The normalised product of densities, each raised to a power."""
    result, *others = (
        Gaussian(each.mean, each.covariance / power)
        for each, power in zip(factors, powers, strict=True)
    )
    for other in others:
        total = result.covariance + other.covariance
        gain = result.covariance @ np.linalg.pinv(total, hermitian=True)
        covariance = result.covariance - gain @ result.covariance
        result = Gaussian(
            result.mean + gain @ (other.mean - result.mean), 0.5 * (covariance + covariance.T)
        )
    return result


def _about(skill: ProMPSkill[MotionT], coordinates: Coordinates[MotionT]) -> ProMPSkill[MotionT]:
    """The skill about another reference orientation, to first order in its spread."""
    if skill.coordinates.kind != "poses" or skill.coordinates is coordinates:
        return skill
    rows, count = skill.basis(NODES), skill.basis.count
    own = rows @ skill.free.mean.reshape(-1, count)[3:].T
    orientations = rotations.compose(skill.coordinates.reference_at(NODES), rotations.exp(own))
    here = coordinates.tangent(orientations, NODES)
    farthest = float(np.linalg.norm(here, axis=1).max())
    if farthest > _MAX_ROTATION:
        raise InvalidInput(
            "skills: expected orientations near each other, at most a right angle apart, "
            f"got {farthest:.3g} rad"
        )
    fit = np.linalg.pinv(rows)
    change = np.eye(6 * count)
    blocks = np.einsum("iu,uab,uj->aibj", fit, carried(own, here), rows)
    change[3 * count :, 3 * count :] = blocks.reshape(3 * count, 3 * count)
    mean = skill.free.mean.copy()
    mean[3 * count :] = (fit @ here).T.ravel()
    covariance = change @ skill.free.covariance @ change.T
    weights = Gaussian(mean, 0.5 * (covariance + covariance.T))
    return replace(skill, coordinates=coordinates, free=weights, experience=None)


def alike(skills: Sequence[ProMPSkill[MotionT]]) -> list[ProMPSkill[MotionT]]:
    """The skills, of columns that mean the same, with joints in the order of the first one."""
    if not isinstance(skills, Sequence) or len(skills) == 0:
        raise InvalidInput("skills: expected a sequence of at least one skill")
    for i, each in enumerate(skills):
        check.instance(each, f"skills[{i}]", ProMPSkill)
    kinds = sorted({(each.coordinates.kind, each.coordinates.size) for each in skills})
    if len(kinds) > 1:
        got = " and ".join(f"{kind} of {size} columns" for kind, size in kinds)
        raise check.refused(
            "skills", "all of points of one dimension, all of the same joints or all of poses", got
        )
    names = skills[0].coordinates.joint_names
    return [_with_joints(each, names, f"skills[{i}]") for i, each in enumerate(skills)]


def _with_joints(
    skill: ProMPSkill[MotionT], names: tuple[str, ...], argument: str
) -> ProMPSkill[MotionT]:
    """The skill with its columns in the order of `names`."""
    if skill.coordinates.joint_names == names:
        return skill
    columns = check.column_order(skill.coordinates.joint_names, names, argument)
    count, known = skill.basis.count, skill.experience
    rows = np.add.outer(np.multiply(columns, count), np.arange(count)).ravel()
    return replace(
        skill,
        coordinates=replace(skill.coordinates, joint_names=names),
        free=Gaussian(skill.free.mean[rows], skill.free.covariance[np.ix_(rows, rows)]),
        noise=skill.noise[columns],
        scale=skill.scale[columns],
        bounds=skill.bounds and (skill.bounds[0][columns], skill.bounds[1][columns]),
        experience=known
        and replace(
            known,
            curves=known.curves[:, rows],
            noise=known.noise[columns],
            scale=known.scale[columns],
        ),
    )
