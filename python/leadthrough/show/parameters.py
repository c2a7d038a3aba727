"""The main parameter or two of each model, as numbers that a slider may change."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough.models import (
    DMP,
    GMR,
    DMPSkill,
    FastMarchingSkill,
    GMRSkill,
    PoseDMP,
    PoseDMPSkill,
    ProMP,
    ProMPSkill,
)
from leadthrough.motion import Demonstration

# What a slider for a length, such as the tubes' radius, goes to in multiples of the present one.
_LENGTH_SHARES = (0.4, 4.0)


@dataclass(frozen=True, eq=False)
class Parameter:
    """A number of a model. apply: takes another value, gives the skill that it makes."""

    label: str
    value: float
    lower: float
    upper: float
    step: float
    apply: Callable[[float], Any]


def parameters(skill: Any, demonstrations: Sequence[Demonstration] = ()) -> list[Parameter]:
    """What may be changed about a skill.

    demonstrations: those it was fitted to; without them what needs another fit cannot change.
    """
    if isinstance(skill, FastMarchingSkill):
        return _fast_marching(skill)
    shown = list(demonstrations)
    if not shown:
        return []
    if isinstance(skill, DMPSkill | PoseDMPSkill):
        dmp: DMP | PoseDMP = skill.model
        count = len(skill.springs.weights)
        return [_count("weights", count, 100, lambda n: replace(dmp, weights=n).fit(shown))]
    if isinstance(skill, ProMPSkill):
        promp = ProMP(basis=skill.basis.kind)
        count = skill.basis.count
        return [_count("weights", count, 40, lambda n: replace(promp, weights=n).fit(shown))]
    if isinstance(skill, GMRSkill):
        count = len(skill.mixture.weights)
        return [_count("components", count, 20, lambda n: GMR(components=n).fit(shown))]
    return []


def _fast_marching(skill: FastMarchingSkill) -> list[Parameter]:
    def with_model(**changes: Any) -> FastMarchingSkill:
        return replace(skill, model=replace(skill.model, **changes))

    radius = skill.area_of_influence
    least, most = (share * radius for share in _LENGTH_SHARES)
    return [
        Parameter(
            "saturation", skill.model.saturation, 0.005, 0.5, 0.005,
            lambda value: with_model(saturation=value),
        ),
        Parameter(
            "area of influence, m", radius, least, most, (most - least) / 100.0,
            lambda value: with_model(area_of_influence=value),
        ),
    ]  # fmt: skip


def _count(label: str, value: int, most: int, fit: Callable[[int], Any]) -> Parameter:
    least = 5 if label == "weights" else 1

    def apply(number: float) -> Any:
        return fit(int(np.round(number)))

    return Parameter(label, value, min(least, value), max(most, value), 1.0, apply)
