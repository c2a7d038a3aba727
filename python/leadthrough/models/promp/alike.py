"""ProMPs that are used together: all of one type of motion."""

from __future__ import annotations

from collections.abc import Sequence

from leadthrough.errors import InvalidInput
from leadthrough.models.promp.skill import ProMPSkill


def check_alike(skills: Sequence[ProMPSkill]) -> None:
    """Checks that there are skills, and that their columns mean the same."""
    if not isinstance(skills, Sequence) or len(skills) == 0:
        raise InvalidInput("skills: expected a sequence of at least one skill")
    for i, each in enumerate(skills):
        if not isinstance(each, ProMPSkill):
            raise InvalidInput(f"skills[{i}]: expected a ProMPSkill, got {type(each).__name__}")
    kinds = {(each.chart.kind, each.chart.size, each.chart.joint_names) for each in skills}
    if len(kinds) > 1:
        got = " and ".join(
            f"{kind} of {size} columns {list(names) if names else ''}".rstrip()
            for kind, size, names in sorted(kinds)
        )
        raise InvalidInput(
            "skills: expected all of points of one dimension, all of the same joints or all of "
            f"poses, got {got}"
        )
