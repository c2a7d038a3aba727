"""Places that a tip must not go to, because the arm cannot stand there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.shapes import PointCloud
from leadthrough.whole_arm.room import Narrows, Room, turned

# m around a part without room that is looked at: at first, and how much farther in each round.
_REACH, _GROWTH = 0.08, 1.4
# Cells from the middle to the edge of what is looked at.
_CELLS = 3
# Radius of what is closed, in cells: the balls of neighbours overlap.
_COVER = 0.75


def closed_around(
    room: Room,
    tip: Trajectory | PoseTrajectory,
    narrows: Narrows,
    near: Float64Array,
    changes: int,
) -> tuple[PointCloud, ...]:
    """Balls around all places beside a part of a path where the arm cannot stand."""
    reach = _REACH * _GROWTH**changes
    cell = reach / _CELLS
    middles = tip.positions[narrows.samples]
    cells, owners = _cells_around(middles, cell)
    rows = narrows.samples[owners]
    standing = room.stands(cells, turned(tip, rows), near)
    radius = _COVER * cell
    ends = tip.positions[[0, -1]]
    free_of_ends = np.linalg.norm(cells[:, None] - ends, axis=2).min(axis=1) > radius + cell
    closed = cells[~standing & free_of_ends]
    if len(closed) == 0:
        # The arm can stand everywhere, but not come there: the place itself is left out.
        apart = np.linalg.norm(middles[:, None] - ends, axis=2).min(axis=1) > radius + cell
        closed = middles[apart]
    return (PointCloud(closed, radius),) if len(closed) else ()


def _cells_around(middles: Float64Array, cell: float) -> tuple[Float64Array, NDArray[np.int64]]:
    """Cells of a grid within reach of the points, (m, 3), and the nearest point to each, (m,)."""
    reach = _CELLS * cell
    low = np.floor((middles.min(axis=0) - reach) / cell).astype(int)
    high = np.ceil((middles.max(axis=0) + reach) / cell).astype(int)
    axes = [np.arange(a, b + 1) for a, b in zip(low, high, strict=True)]
    cells = cell * np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    away = np.linalg.norm(cells[:, None] - middles, axis=2)
    within = away.min(axis=1) <= reach
    return cells[within], away[within].argmin(axis=1)
