"""Motions of a ProMP between a new start and a new goal, never farther off than they were moved.

The covariance describes the variation inside the demonstrations. If all of them share an end, it
says next to nothing about another one, and conditioning alone would distort the motion: the gain
from the end to the middle is a covariance over a vanishing variance. So the motion is moved by a
mixture of two: conditioned on the new ends, and shifted as a whole by offsets that fade from end to
end. It is conditioned as far as the ends lie within the demonstrations' spread, and as far as no
phase moves by much more than the ends do; the rest is shifted.

Source: Zhou, Gao and Asfour 2019, "Learning via-movement primitives with inter- and extrapolation
capabilities", for the shift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.promp.basis import inner_prior, lines
from leadthrough.models.promp.conditioning import Primitive, PrimitiveT, of_values
from leadthrough.models.promp.gaussian import CERTAIN, Gaussian
from leadthrough.models.queries import MAX_GAIN, fraction_inside
from leadthrough.models.targets import Target

# Standard deviations up to which ends count as demonstrated.
_MAX_DEVIATIONS = 3.0
_PHASES_PER_WEIGHT = 4
_ROUNDING = 1e-9  # fraction of the reach that counts as nothing


@dataclass(frozen=True, eq=False)
class Asked:
    """An end that a query asks for."""

    name: str  # argument that asks for it
    phase: float  # 0 at the start, 1 at the end
    values: Float64Array  # the first columns (p,) there


def asked(coordinates: Coordinates, start: Target | None, goal: Target | None) -> list[Asked]:
    """The ends that a query asks for, in the columns of the coordinates."""
    return [
        Asked(name, phase, coordinates.target(place, name, phase))
        for name, place, phase in (("start", start, 0.0), ("goal", goal, 1.0))
        if place is not None
    ]


def moved(skill: PrimitiveT, asked: Sequence[Asked]) -> PrimitiveT:
    """The skill whose mean motion has the ends asked for."""
    conditioned = skill
    for each in asked:
        conditioned = of_values(
            conditioned, np.array([each.phase]), each.values[None], name=each.name
        )
    size = skill.coordinates.width
    offsets = _offsets(skill, asked)
    shift = _shift(skill, asked, offsets)
    learned = (conditioned.free.mean - skill.free.mean).reshape(size, -1) - shift
    known = min(1.0, _MAX_DEVIATIONS / max(novelty(skill, asked), _MAX_DEVIATIONS))
    rows = _rows(skill)
    for group in _groups(skill):
        limit = MAX_GAIN * _moved_by(skill, asked, offsets, group)
        inside = fraction_inside(rows @ shift[group].T, rows @ learned[group].T, limit)
        shift[group] += min(known, inside) * learned[group]
    mean = skill.free.mean + shift.ravel()
    return skill.with_weights(Gaussian(mean, conditioned.free.covariance))


def novelty(skill: Primitive, asked: Sequence[Asked]) -> float:
    """Distance of ends from the demonstrated ones, in standard deviations."""
    offsets = _offsets(skill, asked)
    selection, surprise = [], []
    for each, offset in zip(asked, offsets, strict=True):
        count = len(each.values)
        row = skill.basis(np.array([each.phase]))[0]
        unit = 1.0 / skill.scale[:count]
        selection.append(np.kron(np.eye(skill.coordinates.width)[:count] * unit[:, None], row))
        surprise.append(offset[:count] * unit)
    rows = np.concatenate(selection)
    variances, axes = np.linalg.eigh(rows @ skill.free.covariance @ rows.T)
    along = np.abs(axes.T @ np.concatenate(surprise))
    with np.errstate(divide="ignore", invalid="ignore"):
        deviations = along / np.sqrt(np.where(variances > CERTAIN**2, variances, 0.0))
    # Fixed and asked to be as it is, up to rounding: nothing new.
    return float(np.where(along < _ROUNDING, 0.0, deviations).max())


def _offsets(skill: Primitive, asked: Sequence[Asked]) -> list[Float64Array]:
    """Offset (d,) of each end; 0 in columns that were not asked for."""
    curves = skill.free.mean.reshape(skill.coordinates.width, -1)
    offsets = []
    for each in asked:
        offset = np.zeros(len(curves))
        present = curves @ skill.basis(np.array([each.phase]))[0]
        offset[: len(each.values)] = each.values - present[: len(each.values)]
        offsets.append(offset)
    return offsets


def _shift(
    skill: Primitive, asked: Sequence[Asked], offsets: Sequence[Float64Array]
) -> Float64Array:
    """Weights (d, k) of the shift; where the motion is fixed, at via points, it does not move."""
    # A rhythmic motion ends where it starts: all of it is shifted.
    fading = np.ones((skill.basis.count, 1)) if skill.basis.is_rhythmic else lines(skill.basis)
    shift = np.zeros((skill.coordinates.width, skill.basis.count))
    for each, offset in zip(asked, offsets, strict=True):
        shift += np.outer(offset, fading[:, int(each.phase)])
    fixed = skill.free.certain
    if fixed.shape[1] > 0:
        smooth = np.kron(np.diag(skill.scale**2), inner_prior(skill.basis)) @ fixed
        wrong = fixed.T @ shift.ravel()
        shift -= (smooth @ np.linalg.pinv(fixed.T @ smooth) @ wrong).reshape(shift.shape)
    return shift


def _groups(skill: Primitive) -> list[slice]:
    """The columns that share a unit: points or joints; a pose's position and its rotation."""
    size, width = skill.coordinates.size, skill.coordinates.width
    return [slice(0, size)] if size == width else [slice(0, size), slice(size, width)]


def _moved_by(
    skill: Primitive,
    asked: Sequence[Asked],
    offsets: Sequence[Float64Array],
    group: slice,
) -> float:
    """The largest offset of the ends in a group of columns, in its unit."""
    if any(len(each.values) >= group.stop for each in asked):
        return max(float(np.linalg.norm(offset[group])) for offset in offsets)
    position = slice(0, skill.coordinates.size)
    reach = np.linalg.norm(skill.scale[group]) / np.linalg.norm(skill.scale[position])
    return float(reach) * max(float(np.linalg.norm(offset[position])) for offset in offsets)


def _rows(skill: Primitive) -> Float64Array:
    return skill.basis(np.linspace(0.0, 1.0, _PHASES_PER_WEIGHT * skill.basis.count + 1))
