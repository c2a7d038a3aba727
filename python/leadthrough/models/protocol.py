"""What every fitted skill offers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from leadthrough.motion import Motion
from leadthrough.shapes import Shape


class Skill(Protocol):
    """A fitted model: frozen, safe to share between threads."""

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours, of "start", "goal", "duration", "obstacles"."""

    def generate(
        self,
        *,
        start: Any = None,
        goal: Any = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> Motion:
        """A motion of the fitted type; what is left out is taken from the demonstrations.

        Raises InvalidInput, UnsupportedQuery for a part that it does not support, NoPath.
        """

    @property
    def kind(self) -> str:
        """What files call skills like this."""

    def to_archive(self) -> tuple[dict[str, Any], Mapping[str, Any]]:
        """Settings and arrays, for a file."""
