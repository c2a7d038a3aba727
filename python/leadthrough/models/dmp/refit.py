"""A primitive fitted again with another number of weights."""

from __future__ import annotations

from collections.abc import Sequence

from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.parameters import Parameter, fitted_again
from leadthrough.models.protocol import Skill
from leadthrough.motion import Motion, MotionT

_LEAST, _MOST = 5, 100  # weights worth trying


def weights_of(
    skill: Skill[MotionT], demonstrations: Demonstrations[Motion]
) -> Sequence[Parameter[MotionT]]:
    """The number of weights of a primitive as a parameter; none without demonstrations."""
    return fitted_again(skill, "weights", demonstrations, least=_LEAST, most=_MOST)
