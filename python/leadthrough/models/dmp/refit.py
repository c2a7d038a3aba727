"""A primitive fitted again with another number of weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.parameters import Parameter, whole_number
from leadthrough.models.protocol import Skill
from leadthrough.motion import Motion, MotionT

_LEAST, _MOST = 5, 100  # weights worth trying


def weights_of(
    skill: Skill[MotionT], demonstrations: Demonstrations[Motion]
) -> Sequence[Parameter[MotionT]]:
    """The number of weights of a primitive; nothing without demonstrations to fit again."""
    if len(demonstrations) == 0:
        return []
    model: Any = skill.model  # a dataclass with weights, one of four

    def fitted(weights: int) -> Skill[MotionT]:
        again: Skill[MotionT] = replace(model, weights=weights).fit(demonstrations)
        return again

    return [whole_number("weights", model.weights, least=_LEAST, most=_MOST, apply=fitted)]
