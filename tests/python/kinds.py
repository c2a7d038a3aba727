"""Every kind of model by its role; a model is built when a test asks for it.

A name that leaves the package breaks the tests that use it, and the collection of none.
"""

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import motions

from leadthrough import rotations
from leadthrough.models.registry import entry_of_class


@dataclass(frozen=True)
class Kind:
    """A model of a family for motions of "points", "joints" or "poses", by its settings."""

    family: str
    motion: str = "points"
    settings: dict[str, Any] = field(default_factory=dict, hash=False)

    def build(self) -> Any:
        return entry_of_class(self.family).load()(**self.settings)

    @property
    def rhythmic(self) -> bool:
        return self.family.startswith("Rhythmic")

    def demonstrated(self, shift: float = 0.0, scale: float = 1.0) -> Any:
        """A motion of the kind that it learns: an arch, or a round of a rhythm."""
        return (motions.ring if self.rhythmic else motions.arch)(self.motion, shift, scale)

    @property
    def query(self) -> "Query":
        return _queries()[self.motion, self.rhythmic]


def kind(family: str, motion: str = "points", **settings: Any) -> Kind:
    return Kind(family, motion, settings)


@dataclass(frozen=True)
class Query:
    """Query near the demonstrated motions: a start, a goal, and a goal that is malformed."""

    start: Any
    goal: Any
    wrong: Any
    ends_at_goal: bool = True  # a rhythm's goal is its centre
    half_speed: Any = field(default_factory=lambda: {"duration": 3.0})


@cache
def _queries() -> dict[tuple[str, bool], Query]:
    def rotated(*vector):
        return rotations.exp([vector])[0]

    of_rhythm = {"ends_at_goal": False, "half_speed": {"period": 3.0}}
    malformed = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0))
    tilted = rotated(0.2, 0.1, 0.0)
    return {
        ("points", False): Query((0.02, 0.03), (0.33, -0.02), (0.0,)),
        ("joints", False): Query((0.02, 0.03, 0.0), (0.33, -0.02, -0.1), (0.0, 0.0)),
        ("poses", False): Query(
            ((0.02, 0.03, 0.0), tilted), ((0.33, -0.02, 0.1), rotated(0.0, 3.2, 4.1)), malformed
        ),
        ("points", True): Query((0.15, 0.0), (0.05, 0.01), (0.0,), **of_rhythm),
        ("poses", True): Query(
            ((0.15, 0.0, 0.0), tilted),
            ((0.05, 0.01, 0.0), rotated(0.0, 0.0, 1.0)),
            malformed,
            **of_rhythm,
        ),
    }


# The contract suite runs over all of them: a new model joins with a line.
KINDS = {
    "movement primitive": kind("DMP"),
    "movement primitive of joints": kind("DMP", "joints"),
    "movement primitive, by its force": kind("DMP", regression="ridge"),
    "movement primitive of poses": kind("DMP", "poses"),
    "movement primitive, rhythmic": kind("RhythmicDMP"),
    "movement primitive of poses, rhythmic": kind("RhythmicDMP", "poses"),
    "aligned mean": kind("AlignedMean"),
    "aligned mean of joints": kind("AlignedMean", "joints"),
    "aligned mean of poses": kind("AlignedMean", "poses"),
    "fast marching": kind("FastMarching"),
    "fast marching of poses": kind("FastMarching", "poses"),
    "fast marching, one map": kind("FastMarching", method="map"),
    "fast marching, by start": kind("FastMarching", method="start"),
    "ProMP": kind("ProMP"),
    "ProMP of joints": kind("ProMP", "joints"),
    "ProMP of poses": kind("ProMP", "poses"),
    "ProMP, B-splines": kind("ProMP", basis="bspline"),
    "ProMP, by EM": kind("ProMP", estimator="em"),
    "ProMP of poses, by EM": kind("ProMP", "poses", estimator="em"),
    "GMR": kind("GMR"),
    "GMR of joints": kind("GMR", "joints"),
    "GMR of poses": kind("GMR", "poses"),
    "GMR, task-parameterised": kind("TaskGMR", components=4),
    "GMR of joints, task-parameterised": kind("TaskGMR", "joints", components=4),
    "GMR of poses, task-parameterised": kind("TaskGMR", "poses", components=4),
    "SEDS": kind("SEDS", components=3),
    "SEDS of joints, least squares": kind("SEDS", "joints", components=3, objective="mse"),
    "LPV-DS of joints": kind("LPVDS", "joints", components=4),
    "CLF-DM": kind("CLFDM", components=4, quadratics=1),
    "FSM-DM": kind("FSMDM", units=10),
    "UMIC": kind("UMIC", kernels=12),
    "modified system": kind("ModifiedDS", units=40, energy_units=5),
}

SHIFTS = (-0.02, 0.0, 0.02)


def demonstrations(of: Kind, scale: float = 1.0) -> list[Any]:
    """Three motions beside each other."""
    return [of.demonstrated(shift, scale) for shift in SHIFTS]


@cache
def learned(role: str) -> Any:
    """The skill of a role, which tests share, as it is frozen."""
    of = KINDS[role]
    return of.build().fit(demonstrations(of))
