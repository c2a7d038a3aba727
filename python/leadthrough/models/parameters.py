"""The few numbers of a skill that a person may drag, such as on a slider of the live view."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic

from leadthrough.motion import MotionT, MotionT_co

if TYPE_CHECKING:
    from leadthrough.models.protocol import Skill


@dataclass(frozen=True, eq=False)
class Parameter(Generic[MotionT_co]):
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
    """A parameter that counts something, such as weights.

    Args:
        label: its name.
        value: the present value; the range is widened to it.
        least: the least value worth trying.
        most: the largest value worth trying.
        apply: takes another value and returns the skill with it.
    """

    def rounded(number: float) -> Skill[MotionT]:
        return apply(round(number))

    return Parameter(label, value, min(least, value), max(most, value), 1.0, rounded)
