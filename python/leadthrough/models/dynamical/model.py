"""From demonstrations to a skill, the same way for all systems."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from leadthrough.blas_threads import one_blas_thread
from leadthrough.errors import FitError
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dynamical.arrival import LONGEST
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.integration import ends
from leadthrough.models.dynamical.samples import NEAR_GOAL, Shown, shown_about_goals
from leadthrough.models.dynamical.skill import DynamicalSkill
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import MotionT

# A system's speed is changed by no more than this: one that is so slow rests somewhere on the way.
_MOST_PACE = 2.0


class DynamicalModel(Unfitted, ABC):
    """A model that learns a system; derived ones hold its settings and say how it is learned."""

    @one_blas_thread
    def fit(self, demonstrations: Demonstrations[MotionT]) -> DynamicalSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.

        Raises:
            InvalidInput: if the demonstrations differ in type.
            FitError: if there is none, one does not move, orientations have no mean at the goal or
                turn by a full turn or more, or the goal is reached from no start.
            MissingDependency: if the model needs the extra `stable` and it is not installed.
        """
        shown = shown_about_goals(demonstrations)
        field = self._learned(shown)
        return DynamicalSkill(
            self,
            shown.chart,
            field,
            shown.scale,
            shown.ends,
            shown.duration,
            _pace(field, shown),
            shown.x,
        )

    @abstractmethod
    def _learned(self, shown: Shown) -> Field:
        """The system of the normalised demonstrations."""


def _pace(field: Field, shown: Shown) -> float:
    """The median over the demonstrations of how much longer the system takes from their starts."""
    starts = np.array([each[0] for each in shown.positions])
    found = ends(field, starts, near=NEAR_GOAL, longest=LONGEST)
    if not found.arrived.any():
        raise FitError(
            "demonstrations: the system that was learned does not reach the goal from any of their "
            "starts; use another model"
        )
    slower = float(np.median((found.times / shown.approaches)[found.arrived]))
    return min(max(slower, 1.0 / _MOST_PACE), _MOST_PACE)
