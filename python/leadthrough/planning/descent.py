"""Quickest paths: down a field of arrival times to its source."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoPath
from leadthrough.planning.arrival import FloatArray
from leadthrough.planning.grid import Grid

_REASONS = {
    "start_outside": "the start lies outside the grid",
    "start_unreached": "the start lies in a wall, or walls separate it from the goal",
    "other_source": "the descent ends at a source that is not the goal's cell",
    "too_many_steps": "the descent does not end",
}


def descend(
    arrival: ArrayLike, grid: Grid, start: ArrayLike, goal: ArrayLike, *, step: float = 0.5
) -> Float64Array:
    """The quickest path from start to goal, points (n, d); both ends are exact.

    No segment enters a cell of infinite arrival (a point's cell is the nearest one), and arrival
    falls along the path: at every point where it is smooth, from cell to cell around narrow
    corners.

    Args:
        arrival: times of grid.shape, from `arrival_times` with the goal's cell as source; inf in
            walls.
        start: point (d,), in the grid's unit.
        goal: point (d,), in the grid's unit.
        step: longest step in cells (of the smallest spacing), below 1.

    Raises:
        InvalidInput: if the goal does not lie in a source's cell.
        NoPath: with reason "start_outside", "start_unreached" or "other_source".
    """
    times = _times(arrival, grid)
    length = check.number(step, "step", at_least=1e-3, below=1.0)
    begin = check.array(start, "start", shape=(grid.dimensions,))
    end = check.array(goal, "goal", shape=(grid.dimensions,))
    if not grid.contains(end[None])[0]:
        raise InvalidInput(f"goal: expected a point in the grid, got {end}")
    first, last = grid.coordinates(np.stack([begin, end])).tolist()
    status, coordinates = core.descend(times, grid.spacing.tolist(), first, last, length)
    if status == "goal_not_source":
        raise InvalidInput(f"goal: expected a point in a source's cell, got {end}")
    if status != "ok":
        raise NoPath(f"no path from {begin} to {end}: {_REASONS[status]}", reason=status)
    path = grid.points_at(coordinates)
    path[0], path[-1] = begin, end
    return path


def direction(arrival: ArrayLike, grid: Grid, positions: ArrayLike) -> Float64Array:
    """Unit vectors (n, d) of the descent at given positions; 0 at a source.

    A step of half a cell or less (of the smallest spacing) in that direction enters no wall; in a
    source's cell the vector points to its centre.

    Args:
        arrival: as for `descend`; contiguous floats are not copied, so that a controller may ask
            in every cycle.
        positions: points (n, d), in the grid's unit.

    Raises:
        NoPath: if a position lies in a wall or is walled off, with reason "start_unreached", or
            lies outside the grid, with reason "start_outside".
    """
    points = check.array(positions, "positions", shape=("n", grid.dimensions))
    times = _floats(arrival, grid)
    status, count, vectors = core.directions(times, grid.spacing.tolist(), grid.coordinates(points))
    if status == "not_times":
        raise InvalidInput(f"arrival: expected times >= 0, got others near {points[count]}")
    if status != "ok":
        raise NoPath(
            f"positions[{count}]: no direction at {points[count]}: {_REASONS[status]}",
            reason=status,
        )
    return vectors


def _times(arrival: ArrayLike, grid: Grid) -> FloatArray:
    times = _floats(arrival, grid)
    if not times.min() >= 0.0:
        raise InvalidInput(f"arrival: expected times >= 0, got {times.min()}")
    return times


def _floats(arrival: ArrayLike, grid: Grid) -> FloatArray:
    raw = np.asarray(arrival)
    if raw.dtype.kind != "f" or raw.shape != grid.shape:
        raise InvalidInput(
            f"arrival: expected floats of the grid's shape {grid.shape}, "
            f"got {raw.shape} of {raw.dtype}"
        )
    if raw.dtype == np.float32:
        return np.ascontiguousarray(raw, np.float32)
    return np.ascontiguousarray(raw, np.float64)
