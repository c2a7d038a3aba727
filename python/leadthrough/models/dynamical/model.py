"""Models of dynamical systems: from demonstrations to a skill."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import FitError
from leadthrough.models.dynamical.field import MAX_DURATION, Field, endpoints
from leadthrough.models.dynamical.samples import NEAR_GOAL, Samples, samples_about_goals
from leadthrough.models.dynamical.skill import DynamicalSkill
from leadthrough.models.protocol import Demonstrations, Unfitted
from leadthrough.motion import MotionT

# Largest factor by which a system's speed is changed: a slower one rests somewhere.
_MAX_PACE = 2.0


class DynamicalModel(Unfitted, ABC):
    """Base of models that learn a system; a derived frozen dataclass holds the settings.

    Attributes:
        system: class of the systems that `learn` returns, which files are read with.
        slider: a setting that a person may drag, with its least and largest value.
    """

    system: ClassVar[type[Field]]
    slider: ClassVar[tuple[str, int, int]]

    @one_blas_thread
    def fit(self, demonstrations: Demonstrations[MotionT]) -> DynamicalSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.

        Raises:
            FitError: if there is none, one does not move, orientations have no mean at the goal or
                turn by a full turn or more, or the goal is reached from no start.
            MissingDependency: if the model needs the extra `stable` and it is not installed.
        """
        samples = samples_about_goals(demonstrations)
        field = self.learn(samples)
        return DynamicalSkill(
            self,
            samples.coordinates,
            field,
            samples.scale,
            samples.ends,
            samples.duration,
            _pace(field, samples),
            samples.x,
        )

    @abstractmethod
    def learn(self, samples: Samples) -> Field:
        """The system of normalised demonstrations.

        Args:
            samples: their positions and velocities.
        """


def _pace(field: Field, samples: Samples) -> float:
    """Median ratio of the system's time from the demonstrations' starts to their own."""
    starts = np.array([each[0] for each in samples.positions])
    reached = endpoints(field, starts, near=NEAR_GOAL, longest=MAX_DURATION)
    if not reached.arrived.any():
        raise FitError(
            "demonstrations: the learned system does not reach the goal from any of their "
            "starts; use another model"
        )
    slower = float(np.median((reached.times / samples.approaches)[reached.arrived]))
    return min(max(slower, 1.0 / _MAX_PACE), _MAX_PACE)
