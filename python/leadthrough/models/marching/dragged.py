"""The numbers of a Fast Marching skill that a person may drag; none of them needs a new fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from leadthrough.models.parameters import Parameter
from leadthrough.motion import MotionT

if TYPE_CHECKING:
    from leadthrough.models.marching.skill import FastMarchingSkill

_SATURATIONS, _STEP = (0.005, 0.5), 0.005
# The radii worth trying, in multiples of the present one, and the steps between them.
_RADII, _STEPS = (0.4, 4.0), 100


def parameters_of(skill: FastMarchingSkill[MotionT]) -> list[Parameter[MotionT]]:
    """The saturation and, where there is a map, the radius of its tubes."""
    saturation = skill.model.saturation
    found = [
        Parameter("saturation", saturation, *_SATURATIONS, _STEP, _changing(skill, "saturation"))
    ]
    if skill.experience:
        radius = skill.area_of_influence
        least, most = (factor * radius for factor in _RADII)
        apply = _changing(skill, "area_of_influence")
        step = (most - least) / _STEPS
        found.append(Parameter("area of influence, m", radius, least, most, step, apply))
    return found


def _changing(
    skill: FastMarchingSkill[MotionT], setting: str
) -> Callable[[float], FastMarchingSkill[MotionT]]:
    """Takes a value of a setting of the model and returns the skill with it."""

    def changed(value: float) -> FastMarchingSkill[MotionT]:
        settings: dict[str, Any] = {setting: value}
        return replace(skill, model=replace(skill.model, **settings))

    return changed
