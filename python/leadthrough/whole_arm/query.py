"""A query to a skill: where and when its motion starts and ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from leadthrough.models.protocol import Place
from leadthrough.repr import ShortRepr


@dataclass(frozen=True, eq=False)
class Query(ShortRepr):
    """A query to a skill, as `skill.generate` takes it.

    Attributes:
        start: where the motion starts; None for the demonstrated start.
        goal: where it ends, likewise.
        duration: s, > 0; None for the skill's own.
        dt: s, > 0, upper bound of the sampling step.
    """

    start: Place | None = None
    goal: Place | None = None
    duration: float | None = None
    dt: float = 0.01

    def arguments(self) -> dict[str, Any]:
        """The arguments of `skill.generate` that are given, by name."""
        given = {"start": self.start, "goal": self.goal, "duration": self.duration, "dt": self.dt}
        return {name: value for name, value in given.items() if value is not None}
