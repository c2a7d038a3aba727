"""Quickest paths down a field of arrival times; FM2, where the wave runs slowly beside obstacles.

Source: Prados et al. 2023, Appl. Sci. 13:2028, section 2, Figs. 4 and 5. The distance to the
obstacles is the exact Euclidean one, where the paper marches a wave from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoPath, ShortRepr
from leadthrough.planning.arrival import FloatArray, Numbers, arrival_times
from leadthrough.planning.grid import Grid, check_grid
from leadthrough.planning.speed_map import distance_transform

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
    check_grid(grid)
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
    raw = check.regular(arrival, "arrival")
    if raw.dtype.kind != "f" or raw.shape != check_grid(grid).shape:
        raise check.refused(
            "arrival", f"floats of the grid's shape {grid.shape}", f"{raw.shape} of {raw.dtype}"
        )
    if raw.dtype == np.float32:
        return np.ascontiguousarray(raw, np.float32)
    return np.ascontiguousarray(raw, np.float64)


Reason = Literal[
    "", "start_outside", "goal_outside", "start_in_wall", "goal_in_wall", "goal_enclosed"
]


@dataclass(frozen=True, eq=False)
class Plan(ShortRepr):
    """A path, or why there is none.

    Attributes:
        path: points (n, d) from start to goal; none if there is no path.
        arrival_time: when the wave arrives at the start; inf if there is no path.
        reason: "" if there is a path; "goal_enclosed" means that walls separate goal and start.
    """

    path: Float64Array
    arrival_time: float
    reason: Reason

    @property
    def found(self) -> bool:
        """Whether there is a path."""
        return not self.reason


def fm2_speed(
    grid: Grid,
    walls: ArrayLike,
    *,
    saturation: float | None = None,
    area_of_influence: float | None = None,
) -> Float64Array:
    """Speeds that grow from 0 in walls to 1 at some distance from them.

    Exactly one of `saturation` and `area_of_influence` sets that distance.

    Args:
        walls: booleans of grid.shape, from `occupied`, `occupied_by_points` or a map.
        saturation: the distance as a fraction, 0 to 1, of the largest distance of any cell to a
            wall; 0 is FM alone, the shortest path.
        area_of_influence: the distance in the grid's unit, > 0.

    Returns:
        Speeds of grid.shape.
    """
    blocked = _walls(walls, grid)
    if (saturation is None) == (area_of_influence is None):
        given = "none" if saturation is None else "both"
        raise InvalidInput(
            f"saturation: expected either it or area_of_influence, not both; got {given}"
        )
    if saturation is not None:
        check.number(saturation, "saturation", at_least=0.0, at_most=1.0)
    if area_of_influence is not None:
        check.number(area_of_influence, "area_of_influence", above=0.0)
    if blocked.all() or not blocked.any():
        return np.where(blocked, 0.0, 1.0)
    distance = distance_transform(blocked, spacing=grid.spacing)
    reach = area_of_influence or (saturation or 0.0) * float(distance.max())
    if reach == 0.0:
        return np.where(blocked, 0.0, 1.0)
    return np.asarray(np.minimum(distance / reach, 1.0))


def plan(speed: ArrayLike, grid: Grid, start: ArrayLike, goal: ArrayLike) -> Plan:
    """The quickest path from a start to a goal.

    Args:
        start: point (d,).
        goal: point (d,).
    """
    return plan_many(speed, grid, check.array(start, "start", shape=("d",))[None], goal)[0]


def plan_many(speed: ArrayLike, grid: Grid, starts: ArrayLike, goal: ArrayLike) -> list[Plan]:
    """The quickest paths from several starts to one goal, on one field of arrival times.

    Args:
        speed: of grid.shape, 0 in walls, from `fm2_speed` or any map.
        starts: points (k, d).
        goal: point (d,).

    Returns:
        A plan for each start; one without a path says why.
    """
    check_grid(grid)
    points = check.array(starts, "starts", shape=("k", grid.dimensions))
    end = check.array(goal, "goal", shape=(grid.dimensions,))
    field = check.regular(speed, "speed")
    if field.shape != grid.shape:
        raise InvalidInput(f"speed: expected the grid's shape {grid.shape}, got {field.shape}")
    if not grid.contains(end[None])[0]:
        return [_no_path(grid, "goal_outside") for _ in points]
    source = grid.cells_of(end[None])
    if field[tuple(source[0])] == 0.0:
        return [_no_path(grid, "goal_in_wall") for _ in points]
    arrival = arrival_times(field, source, spacing=grid.spacing)
    return [_descended(arrival, field, grid, point, end) for point in points]


def _walls(walls: ArrayLike, grid: Grid) -> NDArray[np.bool_]:
    blocked = check.regular(walls, "walls")
    if blocked.dtype != np.bool_ or blocked.shape != check_grid(grid).shape:
        raise InvalidInput(
            f"walls: expected booleans of the grid's shape {grid.shape}, "
            f"got shape {blocked.shape} of {blocked.dtype}"
        )
    return blocked


def _no_path(grid: Grid, reason: Reason) -> Plan:
    return Plan(np.empty((0, grid.dimensions)), np.inf, reason)


def _descended(
    arrival: Float64Array, speed: Numbers, grid: Grid, start: Float64Array, goal: Float64Array
) -> Plan:
    try:
        path = descend(arrival, grid, start, goal)
    except NoPath as error:
        if error.reason == "start_outside":
            return _no_path(grid, "start_outside")
        wall = speed[tuple(grid.cells_of(start[None])[0])] == 0.0
        return _no_path(grid, "start_in_wall" if wall else "goal_enclosed")
    return Plan(path, float(arrival[tuple(grid.cells_of(start[None])[0])]), "")
