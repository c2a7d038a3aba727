"""The few numbers of a skill that a person may drag, such as on a slider of the live view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic

from leadthrough.models.demonstrated import Demonstrations
from leadthrough.motion import Motion, MotionT, MotionT_co
from leadthrough.repr import ShortRepr

if TYPE_CHECKING:
    from leadthrough.models.protocol import Skill


@dataclass(frozen=True, eq=False)
class Parameter(ShortRepr, Generic[MotionT_co]):
    """A number of a skill's model that may be changed.

    Attributes:
        label: its name, with the unit where it has one.
        value: the present value.
        lower: the least value worth trying.
        upper: the largest value worth trying.
        step: the smallest change worth making.
        apply: takes another value and returns the skill with it; the skill itself stays as it is.
    """

    label: str
    value: float
    lower: float
    upper: float
    step: float
    apply: Callable[[float], Skill[MotionT_co]]


def whole_number(
    label: str, value: int, *, least: int, most: int, apply: Callable[[int], Skill[MotionT]]
) -> Parameter[MotionT]:
    """A parameter that counts something, such as weights."""

    def rounded(number: float) -> Skill[MotionT]:
        return apply(round(number))

    return Parameter(label, value, min(least, value), max(most, value), 1.0, rounded)


def fitted_again(
    skill: Skill[MotionT],
    setting: str,
    demonstrations: Demonstrations[Motion],
    *,
    least: int,
    most: int,
) -> Sequence[Parameter[MotionT]]:
    """The parameter that fits a skill again with another whole number in its model."""
    if len(demonstrations) == 0:
        return []
    model: Any = skill.model  # a dataclass with this setting

    def fitted(number: int) -> Skill[MotionT]:
        again: Skill[MotionT] = replace(model, **{setting: number}).fit(demonstrations)
        return again

    return [whole_number(setting, getattr(model, setting), least=least, most=most, apply=fitted)]
