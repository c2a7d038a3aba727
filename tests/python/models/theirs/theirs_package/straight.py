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

    def _answer(self, query):
        first = self.ends[0] if query.start is None else np.asarray(query.start)
        last = self.ends[1] if query.goal is None else np.asarray(query.goal)
        seconds = query.duration or self.duration
        u = np.linspace(0.0, 1.0, 1 + round(seconds / query.dt))
        return lt.Trajectory(seconds * u, first + np.outer(u, last - first))

    def to_archive(self):
        return {"model": asdict(self.model), "duration": self.duration}, {"ends": self.ends}


def from_archive(settings, arrays):
    return StraightSkill(Straight(**settings["model"]), arrays["ends"], settings["duration"])
