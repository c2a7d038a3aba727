"""Paths between two points that follow demonstrations, planned in a speed map of them.

`through_map`: Algorithm 1 of Prados et al. 2023, all demonstrations in one map. `from_start`: the
demonstrations count by how near they start. The module `along_mean` has the third way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from leadthrough.brief import Brief
from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.extent import grid_over
from leadthrough.models.marching.hindrance import hindered, passable
from leadthrough.models.marching.query import Query
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.arrival import arrival_times
from leadthrough.planning.descent import descend
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import experience_map, tube_map
from leadthrough.preprocess.resample import arc_length
from leadthrough.preprocess.smooth_path import smooth_path

# Grid noise is shorter than this many cells; the shapes of demonstrations are not.
CELLS_PER_KNOT = 8.0
# Width of the weights over the demonstrations' starts, in their mean distance from each other.
_START_WIDTH = 0.25


@dataclass(frozen=True, eq=False)
class Route(Brief):
    """A path and how it was found.

    Attributes:
        path: (n, d), dense and smooth.
        speed: (n,) the map's speed along it, in (0, 1].
        used: the demonstrations that it follows, facing its way.
        weights: (k,) how much each one's timing counts.
        method: the method that found it, "map", "start" or "mean_path": with "auto", whether it
            follows the demonstrations' prediction or plans anew in the map.
        leaves_usual_way: whether it is farther from the usual motion, the one between the mean ends
            of the demonstrations, than 1.5 times what its ends are moved and an area of influence:
            where obstacles stand on the usual way, or where start and goal are a demonstration's
            that goes another one.
    """

    path: Float64Array
    speed: Float64Array
    used: tuple[Experience, ...]
    weights: Float64Array
    method: str
    leaves_usual_way: bool = False

    @property
    def length(self) -> float:
        """Arc length of the path, in its unit."""
        return float(arc_length(self.path)[-1])

    @property
    def travel_time(self) -> float:
        """When a wave of the map's speed arrives at its end, in the path's unit."""
        steps = np.linalg.norm(np.diff(self.path, axis=0), axis=1)
        return float((steps * 0.5 * (1.0 / self.speed[1:] + 1.0 / self.speed[:-1])).sum())


def through_map(
    known: Sequence[Experience],
    query: Query,
    scales: Scales,
    *,
    useful: Sequence[Experience] | None = None,
) -> Route:
    """The quickest path in the map of demonstrations.

    Args:
        known: demonstrations and learned paths, which may be none.
        query: start, goal and obstacles.
        scales: of the map.
        useful: those of them that are in the map; None: all. Without any, the others still tell
            the timing.

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    mapped = known if useful is None else useful
    paths = [each.way for each in mapped]
    grid, scales = grid_over([*paths, query.ends], query.obstacles, scales)
    speed = experience_map(
        grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
    )
    path = _through(grid, speed, query, scales)
    speed = hindered(speed, grid, query.obstacles, scales)
    used = tuple(each.facing(query.start, query.goal) for each in mapped or known)
    return route_along(path, grid, speed, used=used, weights=np.ones(len(used)), method="map")


def from_start(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The quickest path in a map where demonstrations count by how near they start.

    Args:
        known: demonstrations and learned paths, at least one.
        query: start, goal and obstacles.
        scales: of the map.

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    used = tuple(each.facing(query.start, query.goal) for each in known)
    weights = _nearness(np.stack([each.path[0] for each in used]), query.start)
    paths = [each.way for each in used]
    grid, scales = grid_over([*paths, query.ends], query.obstacles, scales)
    speed = tube_map(
        grid, paths, weights, area_of_influence=scales.radius, saturation=scales.saturation
    )
    path = _through(grid, speed, query, scales)
    speed = hindered(speed, grid, query.obstacles, scales)
    return route_along(path, grid, speed, used=used, weights=weights, method="start")


def _through(grid: Grid, speed: Float64Array, query: Query, scales: Scales) -> Float64Array:
    """The quickest path (n, d) of a query in a map without its obstacles."""
    map_around = passable(speed, grid, query.obstacles, scales)
    return quickest(grid, map_around, query.start, query.goal)


def quickest(
    grid: Grid, speed: NDArray[Any], start: Float64Array, goal: Float64Array, *, order: int = 2
) -> Float64Array:
    """The path (n, d) of least time, computed in the speed's precision.

    Args:
        grid: cells of the map.
        speed: in each cell, 0 in obstacles.
        start: (d,).
        goal: (d,).
        order: of the upwind differences, 1 or 2.

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    start_cell, goal_cell = grid.cells_of(np.stack([start, goal]))
    for name, point, cell in (("start", start, start_cell), ("goal", goal, goal_cell)):
        if speed[tuple(cell)] == 0.0:
            raise NoPath(f"{name}: {point} lies in an obstacle", reason=f"{name}_in_wall")
    arrival = arrival_times(
        speed, goal_cell, spacing=grid.spacing, order=order, dtype=speed.dtype, stop=start_cell
    )
    if np.isinf(arrival[tuple(start_cell)]):
        raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
    return descend(arrival, grid, start, goal)


def route_along(
    path: Float64Array,
    grid: Grid,
    speed: NDArray[Any],
    *,
    used: tuple[Experience, ...],
    weights: Float64Array,
    method: str,
    knot_spacing: float | None = None,
    region: tuple[Float64Array, Float64Array] | None = None,
) -> Route:
    """A path made smooth where obstacles allow, with the map's speed along it.

    Args:
        path: (n, d).
        grid: cells of the map.
        speed: in each cell, 0 in obstacles.
        used: the demonstrations that it follows.
        weights: (k,) how much each one's timing counts.
        method: the method that found it.
        knot_spacing: length below which details vanish; None: that of the noise of the grid.
        region: corners (lower, upper) that the smooth path is kept in.
    """
    walls = speed == 0.0
    smoothed = smooth_path(
        path,
        knot_spacing=knot_spacing or CELLS_PER_KNOT * float(grid.spacing.max()),
        accept=lambda points: not walls[tuple(grid.cells_of(points).T)].any(),
    )
    if region is not None:
        smoothed = np.clip(smoothed, *region)
    along = map_coordinates(
        speed, grid.coordinates(smoothed).T, np.float64, order=1, mode="nearest"
    )
    # Between a free cell and a wall the interpolated speed may vanish; a path never stands still.
    slowest = float(speed[~walls].min())
    return Route(smoothed, np.maximum(along, slowest), used, weights, method)


def _nearness(starts: Float64Array, start: Float64Array) -> Float64Array:
    """Weights (k,), 1 for the nearest start: far from all of them it still counts in full."""
    apart = np.linalg.norm(starts[:, None] - starts[None], axis=2)
    pairs = apart[np.triu_indices(len(starts), 1)]
    if len(starts) == 1 or pairs.mean() == 0.0:
        return np.ones(len(starts))
    squared = ((starts - start) ** 2).sum(axis=1)
    width = _START_WIDTH * float(pairs.mean())
    return np.asarray(np.exp(-(squared - squared.min()) / (2.0 * width**2)))
