"""Stability as it can be seen: many starts, an energy that falls, and no other place of rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.arrival import LONGEST, NEAR
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.integration import ends
from leadthrough.repr import ShortRepr

# Deviation of starts about the demonstrations' samples, in sizes of the motion.
_ABOUT = 0.05
# Points of the grid on which other places of rest are looked for, at most.
_GRID = 40_000
# A system is at rest where it moves slower than this, in sizes per duration and size of distance.
_AT_REST = 1e-3


@dataclass(frozen=True, eq=False)
class StabilityReport(ShortRepr):
    """How a system did from many starts.

    Attributes:
        starts: number of starts.
        arrived: how many came within 1 % of the motion's size of the goal.
        rising: how many trajectories had an energy that did not fall at one of their samples.
        resting: number of points of a fine grid, away from the goal, at which the system is nearly
            at rest.
        longest: the longest that a trajectory took, in durations of the demonstrations.
        lost: up to ten starts (m, d), normalised, that did not arrive.
    """

    starts: int
    arrived: int
    rising: int
    resting: int
    longest: float
    lost: Float64Array

    @property
    def violations(self) -> int:
        """Starts that did not arrive, energies that rose and other places of rest."""
        return self.starts - self.arrived + self.rising + self.resting

    @property
    def ok(self) -> bool:
        """Whether there is no violation."""
        return self.violations == 0


def examined(
    field: Field, shown: Float64Array, count: int, around: float, rng: np.random.Generator
) -> StabilityReport:
    """The report of a system."""
    lower, upper = _box(shown, around)
    half = count // 2
    about = shown[rng.integers(len(shown), size=half)]
    starts = np.concatenate(
        [
            about + _ABOUT * rng.standard_normal(about.shape),
            rng.uniform(lower, upper, (count - half, shown.shape[1])),
        ]
    )
    found = ends(field, starts, near=NEAR, longest=LONGEST)
    return StabilityReport(
        count,
        int(found.arrived.sum()),
        int((~found.falling).sum()),
        _resting(field, lower, upper, rng),
        float(found.times.max()),
        starts[~found.arrived][:10],
    )


def _box(shown: Float64Array, around: float) -> tuple[Float64Array, Float64Array]:
    low, high = shown.min(axis=0), shown.max(axis=0)
    margin = around * (high - low)
    return low - margin, high + margin


def _resting(
    field: Field, lower: Float64Array, upper: Float64Array, rng: np.random.Generator
) -> int:
    """Points of a grid over a box, or of as many random ones in more than three dimensions."""
    d = len(lower)
    if d <= 3:
        lines = np.linspace(lower, upper, int(_GRID ** (1 / d))).T
        points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, d)
    else:
        points = rng.uniform(lower, upper, (_GRID, d))
    distance = np.linalg.norm(points, axis=1)
    away = distance > NEAR
    speed = np.linalg.norm(field.velocity(points[away]), axis=1)
    return int((speed < _AT_REST * np.minimum(distance[away], 1.0)).sum())
