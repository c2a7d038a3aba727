"""States of a motion that goes on in the frame of its task, seen from the base frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import UnsupportedQuery
from leadthrough.models.frame import Frame


@dataclass(frozen=True, eq=False)
class FramedState:
    """A state in the base frame; made by `FramedSkill.begin` and `FramedSkill.step`.

    Attributes:
        inside: the state as the skill in the frame has it.
        frame: of the task, in the base frame.
    """

    inside: Any
    frame: Frame

    @property
    def phase(self) -> float:
        """From 0 at the start on; 1 is the end."""
        return float(self.inside.phase)

    @property
    def duration(self) -> float:
        """Of the whole motion, s."""
        return float(self.inside.duration)

    @property
    def position(self) -> Float64Array:
        """Of shape (d,)."""
        return np.asarray(self.inside.position @ self.frame.axes.T + self.frame.origin)

    @property
    def velocity(self) -> Float64Array:
        """Of shape (d,), per second."""
        return np.asarray(self.inside.velocity @ self.frame.axes.T)

    @property
    def orientation(self) -> Float64Array:
        """Orientation (4,) of a pose, w, x, y, z."""
        own = self._of_pose("orientation")
        return np.asarray(rotations.compose(self.frame.orientations(1), own[None])[0])

    @property
    def angular_velocity(self) -> Float64Array:
        """Angular velocity (3,) of a pose, rad/s."""
        return np.asarray(self._of_pose("angular_velocity") @ self.frame.axes.T)

    def _of_pose(self, name: str) -> Float64Array:
        if not hasattr(self.inside, name):
            raise UnsupportedQuery(f"{name}: the motion is not one of poses; use position")
        return np.asarray(getattr(self.inside, name))
