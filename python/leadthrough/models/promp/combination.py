"""Several ProMPs at once, and one after the other.

Source: Paraschos et al. 2018, "Using probabilistic movement primitives in robotics", eqs. 12 to 14.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.chart import NODES, Chart
from leadthrough.models.promp.gaussian import Gaussian, product
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.motion import normalised_times

# Added to what is certain, in shares of the motion's reach, so that it can be divided by.
_CERTAIN = 1e-7
# Rotation vectors farther from a reference are no longer nearly a linear space.
_FARTHEST = 0.5 * np.pi


def combine(skills: Sequence[ProMPSkill], *, activations: Any = None) -> ProMPSkill:
    """The motions that all skills find likely at once: the product of their distributions.

    activations: (k,) > 0, the powers of the factors, by default all 1. The result has the first
    one's duration, noise, limits and, of poses, reference orientation. Raises InvalidInput for
    skills of different bases or types, and for poses more than a right angle apart.
    """
    _refuse_strangers(skills)
    skills = [_about(each, skills[0].chart) for each in skills]
    if len({each.basis for each in skills}) > 1:
        raise InvalidInput("skills: expected all of one basis with as many weights")
    shares = np.ones(len(skills)) if activations is None else _activations(activations, skills)
    weights = product([each.weights for each in skills], [float(share) for share in shares])
    if skills[0].bounds is None:
        return replace(skills[0], weights=weights)
    return replace(skills[0], weights=weights).within(*skills[0].bounds)


def blend(
    skills: Sequence[ProMPSkill], times: Any, activations: Any
) -> tuple[Float64Array, Float64Array]:
    """Mean (n, d) and covariance (n, d, d) of a motion that goes over from skill to skill.

    times: (n,) s, of the whole motion; each skill runs over all of it, whatever its duration.
    activations: (n, k) >= 0, of each skill at each time, not all 0 at one. Of poses the columns are
    those of `skills[0].chart`, whose `motion` makes a trajectory of them. Raises InvalidInput, also
    for poses more than a right angle apart.
    """
    _refuse_strangers(skills)
    skills = [_about(each, skills[0].chart) for each in skills]
    at = check.times(times, "times")
    shares = check.array(activations, "activations", shape=(len(at), len(skills)))
    if (shares < 0.0).any() or (shares.sum(axis=1) == 0.0).any():
        raise InvalidInput("activations: expected numbers >= 0, not all 0 at any time")
    phases = normalised_times(at)
    precision, pull = 0.0, 0.0
    for each, share in zip(skills, shares.T, strict=True):
        mean, covariance = each.distribution(phases * each.duration)
        inverse = np.linalg.inv(covariance + np.diag((_CERTAIN * each.scale) ** 2))
        weighted = inverse * share[:, None, None]
        precision = precision + weighted
        pull = pull + weighted @ mean[:, :, None]
    blended = np.linalg.inv(precision)
    mean = (blended @ pull)[:, :, 0]
    return mean, 0.5 * (blended + blended.transpose(0, 2, 1))


def _activations(value: Any, skills: Sequence[ProMPSkill]) -> Float64Array:
    shares = check.array(value, "activations", shape=(len(skills),))
    if not (shares > 0.0).all():
        raise InvalidInput(f"activations: expected numbers > 0, got {shares}")
    return shares


def _refuse_strangers(skills: Sequence[ProMPSkill]) -> None:
    if not isinstance(skills, Sequence) or len(skills) == 0:
        raise InvalidInput("skills: expected at least one")
    for each in skills:
        if not isinstance(each, ProMPSkill):
            raise InvalidInput(f"skills: expected ProMPSkill, got {type(each).__name__}")
    kinds = {(each.chart.kind, each.chart.size, each.chart.joint_names) for each in skills}
    if len(kinds) > 1:
        raise InvalidInput("skills: expected all of the same points or the same joints")


def _about(skill: ProMPSkill, chart: Chart) -> ProMPSkill:
    """The skill about the reference orientation of another chart, to first order in its spread."""
    if skill.chart.kind != "poses" or skill.chart is chart:
        return skill
    rows, count = skill.basis(NODES), skill.basis.count
    own = rows @ skill.weights.mean.reshape(-1, count)[3:].T
    turned = rotations.compose(skill.chart.reference_at(NODES), rotations.exp(own))
    here = chart.tangent(turned, NODES)
    farthest = float(np.linalg.norm(here, axis=1).max())
    if farthest > _FARTHEST:
        raise InvalidInput(
            f"skills: expected orientations near each other, got some {farthest:.3g} rad apart"
        )
    # log(exp(d) exp(v)) = d + J_r(d)^-1 v + ..., with J_r(d) = J_l(-d); Sola et al. 2018, eq. 151.
    turning = rotations.left_jacobian_inverse(-here) @ rotations.left_jacobian(-own)
    fit = np.linalg.pinv(rows)
    change = np.eye(6 * count)
    blocks = np.einsum("iu,uab,uj->aibj", fit, turning, rows)
    change[3 * count :, 3 * count :] = blocks.reshape(3 * count, 3 * count)
    mean = skill.weights.mean.copy()
    mean[3 * count :] = (fit @ here).T.ravel()
    covariance = change @ skill.weights.covariance @ change.T
    weights = Gaussian(mean, 0.5 * (covariance + covariance.T))
    return replace(skill, chart=chart, weights=weights)
