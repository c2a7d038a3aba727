"""Straight lines at constant speed, from the first demonstrated start to the goal."""

from dataclasses import asdict, dataclass

import numpy as np

import leadthrough as lt
from leadthrough.models import FittedSkill


@dataclass(frozen=True)
class Straight:
    """The model.

    Attributes:
        pace: factor of the demonstrated duration, > 0.
    """

    pace: float = 1.0

    def fit(self, demonstrations):
        motion = demonstrations[0].motion
        return StraightSkill(self, motion.positions[[0, -1]], self.pace * motion.duration)


@dataclass(frozen=True, eq=False)
class StraightSkill(FittedSkill):
    """The skill."""

    model: Straight
    ends: np.ndarray
    duration: float

    kind = "straight"
    supports = frozenset({"start", "goal", "duration"})

    def generate(self, *, start=None, goal=None, duration=None, dt=0.01):
        first = self.ends[0] if start is None else np.asarray(start)
        last = self.ends[1] if goal is None else np.asarray(goal)
        seconds = duration or self.duration
        u = np.linspace(0.0, 1.0, 1 + round(seconds / dt))
        return lt.Trajectory(seconds * u, first + np.outer(u, last - first))

    def to_archive(self):
        return {"model": asdict(self.model), "duration": self.duration}, {"ends": self.ends}


def from_archive(settings, arrays):
    return StraightSkill(Straight(**settings["model"]), arrays["ends"], settings["duration"])
