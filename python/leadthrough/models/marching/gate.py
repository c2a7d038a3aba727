"""A gate across the start of a motion that returns to it.

A place does not tell whether the tool is about to start or has come back. A wall across the way,
just before the start, lets the wave from the goal reach the start only the way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.grid import Grid
from leadthrough.preprocess.resample import by_arc_length

# Ends closer than this fraction of the length are one place.
_RETURNS = 0.05
_SAMPLES = 1000
_TANGENT = 30  # samples from the start and to the end that tell the direction
# Ways out and in that turn back by more than 120 degrees lie in one tube: no gate parts them.
_LEAST_NORMAL = 1.0
# From the start back to the gate and to the goal, in cells' edges.
_TO_GATE, _TO_GOAL = 2.0, 4.0
# Half width: in radii, so that it closes the tube, and as a fraction of length times saturation,
# so that the way past it takes longer than the way round; at most a part of the extent.
_RADII, _LENGTHS, _EXTENT = 2.5, 0.75, 0.25


@dataclass(frozen=True, eq=False)
class Gate:
    """A disc across the way."""

    middle: Float64Array  # (d,)
    normal: Float64Array  # unit vector (d,) along the way
    width: float  # half of the disc's
    thickness: float  # half of it
    goal: Float64Array  # (d,) the place before the gate where the motion ends

    def holds(self, points: Float64Array) -> NDArray[np.bool_]:
        """Whether points (..., d) lie in it, (...)."""
        along, across = self._parts(points)
        return np.asarray((np.abs(along) <= self.thickness) & (across <= self.width))

    def is_passed(self, point: Float64Array) -> bool:
        """Whether a point (d,) lies beyond the gate, where the motion starts, or beside it."""
        along, across = self._parts(point)
        return bool((along > -self.thickness) | (across > self.width))

    def _parts(self, points: Float64Array) -> tuple[Float64Array, Float64Array]:
        away = points - self.middle
        along = away @ self.normal
        return along, np.linalg.norm(away - along[..., None] * self.normal, axis=-1)


def gate_at(
    known: Sequence[Experience], goal: Float64Array, grid: Grid, scales: Scales
) -> Gate | None:
    """The gate before a goal (d,) where all demonstrations start and end, or None elsewhere."""
    for each in known:
        ends = each.way[[0, -1]]
        if np.linalg.norm(ends - goal, axis=1).max() > _RETURNS * each.length:
            return None
    mean = np.mean([by_arc_length(each.way, _SAMPLES) for each in known], axis=0)
    out, back = mean[_TANGENT] - mean[0], mean[-1] - mean[-1 - _TANGENT]
    normal = out / np.linalg.norm(out) + back / np.linalg.norm(back)
    if np.linalg.norm(normal) < _LEAST_NORMAL:
        return None
    normal = normal / np.linalg.norm(normal)
    cell = float(grid.spacing.max())
    length = float(np.mean([each.length for each in known]))
    width = max(_RADII * scales.radius, _LENGTHS * scales.saturation * length)
    return Gate(
        middle=goal - _TO_GATE * cell * normal,
        normal=normal,
        width=min(width, _EXTENT * float(np.ptp(mean, axis=0).max())),
        # Half a diagonal: no step between neighbouring cells leads through.
        thickness=0.5 * float(np.linalg.norm(grid.spacing)),
        goal=goal - _TO_GOAL * cell * normal,
    )
