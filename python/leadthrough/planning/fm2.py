"""FM2: paths that keep clear of obstacles, because the wave runs slowly beside them.

Source: Prados et al. 2023, Appl. Sci. 13:2028, section 2, Figs. 4 and 5. The distance to the
obstacles is the exact Euclidean one, where the paper marches a wave from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoPath, ShortRepr
from leadthrough.planning.arrival import Numbers, arrival_times
from leadthrough.planning.descent import descend
from leadthrough.planning.grid import Grid
from leadthrough.planning.obstacles import distance_transform

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
    points = check.array(starts, "starts", shape=("k", grid.dimensions))
    end = check.array(goal, "goal", shape=(grid.dimensions,))
    field = np.asarray(speed)
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
    blocked = np.asarray(walls)
    if blocked.dtype != np.bool_ or blocked.shape != grid.shape:
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
