"""How skills are shown: by their settings in a few lines, and by the motion that they generate."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from leadthrough.drawing.drawn import Drawn
from leadthrough.errors import InvalidInput
from leadthrough.models.protocol import Distributed
from leadthrough.motion import Motion

if TYPE_CHECKING:
    from leadthrough.drawing.panels import Panel


class ShownSkill(Drawn):
    """A skill; its drawing is its own motion, with two standard deviations where it knows them."""

    @property
    @abstractmethod
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours."""

    @abstractmethod
    def generate(self) -> Motion:
        """Its own motion."""

    @cached_property
    def _own_motion(self) -> Motion | None:
        """What queries are compared with; None if it was shown nothing."""
        try:
            return self.generate()
        except InvalidInput:  # nothing was shown, so there is no motion without a start and goal
            return None

    def _repr_parts(self) -> list[str]:
        told: dict[str, Any] = {name: getattr(self, name, None) for name in ("model", "duration")}
        parts = [repr(told["model"])] if told["model"] is not None else []
        if told["duration"] is not None:
            parts.append(f"{told['duration']:.4g} s")
        return [*parts, f"supports {', '.join(sorted(self.supports))}"]

    def _panels(self) -> Sequence[Panel]:
        motion = self.generate()
        if not isinstance(self, Distributed):
            return motion._panels()
        times = np.minimum(motion.times - motion.times[0], self.duration)
        _, covariance = self.distribution(times)
        deviations = np.sqrt(np.einsum("nii->ni", covariance))
        return motion._panels(deviations[:, : motion.positions.shape[1]])
