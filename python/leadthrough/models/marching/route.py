"""Paths between two points that follow demonstrations, planned in one of three speed maps.

`through_map`: Algorithm 1 of Prados et al. 2023, all demonstrations in one map. `from_start`: the
demonstrations count by how near they start. `along_mean`: the tube around the path that they
predict, cut where it meets itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, NoPath
from leadthrough.models.marching import mean_path
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.pieces import cut_at_short_cuts
from leadthrough.models.marching.query import Query
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.arrival import arrival_times
from leadthrough.planning.descent import descend
from leadthrough.planning.grid import Grid
from leadthrough.planning.obstacles import bounding_radius
from leadthrough.planning.speed_map import add_obstacles, experience_map, tube_map
from leadthrough.preprocess.resample import arc_length
from leadthrough.preprocess.smooth_path import smooth_path
from leadthrough.shapes import Shape

_CELLS_PER_RADIUS = 5.0
# A tube of a thinner radius is not a tube.
_LEAST_CELLS_PER_RADIUS = 2.0
# Beyond this many cells a default resolution gets coarser: 160 cubed, half a second to march.
_MOST_DEFAULT_CELLS = 4_000_000
# Grid noise is shorter than this many cells; the shapes of demonstrations are not.
_CELLS_PER_KNOT = 8.0
# Room around everything, in radii, and around obstacles, as a fraction of the extent.
_MARGIN = 4.0
_ROOM = 0.25
# Room for a policy around its goal, as a fraction of the demonstrations' extent.
_PUSHED = 1.25
# Width of the weights over the demonstrations' starts, in their mean distance from each other.
_START_WIDTH = 0.25


@dataclass(frozen=True, eq=False)
class Route:
    """A path and how it was found.

    Attributes:
        path: (n, d), dense and smooth.
        speed: (n,) the map's speed along it, in (0, 1].
        used: the demonstrations that it follows, facing its way.
        weights: (k,) how much each one's timing counts.
        method: the method that found it.
    """

    path: Float64Array
    speed: Float64Array
    used: tuple[Experience, ...]
    weights: Float64Array
    method: str


def through_map(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The quickest path in the map of all demonstrations.

    Args:
        known: demonstrations and learned paths, which may be none.
        query: start, goal and obstacles.
        scales: of the map.

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    paths = [each.way for each in known]
    grid, scales = grid_over([*paths, query.ends], query.obstacles, scales)
    speed = experience_map(
        grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
    )
    speed = add_obstacles(speed, grid, query.obstacles, area_of_influence=scales.clearance)
    path = quickest(grid, speed, query.start, query.goal)
    used = tuple(each.facing(query.start, query.goal) for each in known)
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
    speed = add_obstacles(speed, grid, query.obstacles, area_of_influence=scales.clearance)
    path = quickest(grid, speed, query.start, query.goal)
    return route_along(path, grid, speed, used=used, weights=weights, method="start")


def along_mean(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The quickest path in the tube around the demonstrations' mean path.

    Args:
        known: demonstrations and learned paths, at least one.
        query: start, goal and obstacles.
        scales: of the map.

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    faced = [each.facing(query.start, query.goal) for each in known]
    mean = mean_path.predict([each.way for each in faced], query.start, query.goal)
    way = mean.path
    if scales.workspace is not None:
        way = np.clip(way, *scales.workspace)  # start and goal decide whether that is an error
        way[[0, -1]] = query.ends
    grid, scales = grid_over([way], query.obstacles, scales)
    free = add_obstacles(
        np.ones(grid.shape), grid, query.obstacles, area_of_influence=scales.clearance
    )
    path = _along_tube(way, grid, free, scales)
    speed = free * _tube(way, grid, scales)
    chosen = mean.weights > 0.0
    used = tuple(each for each, wanted in zip(faced, chosen, strict=True) if wanted)
    weights = np.ones(len(used))  # whose start is nearest says nothing about the pace
    return route_along(path, grid, speed, used=used, weights=weights, method="mean_path")


def field_to(
    known: Sequence[Experience], goal: Float64Array, obstacles: Sequence[Shape], scales: Scales
) -> tuple[Grid, Float64Array]:
    """The field of a wave that starts at a goal, in the map of all demonstrations.

    There is room in it for a tool that was pushed away.

    Args:
        known: demonstrations and learned paths, at least one.
        goal: (d,).
        obstacles: shapes in the same frame.
        scales: of the map.

    Returns:
        The grid, and arrival times in its cells.

    Raises:
        InvalidInput: if the goal lies outside a workspace that was set.
        NoPath: if the goal lies in an obstacle.
    """
    paths = [each.way for each in known]
    room = _PUSHED * float(np.ptp(np.concatenate(paths), axis=0).max())
    around = np.concatenate([goal[None] - room, goal[None] + room, *paths])
    if scales.workspace is not None:
        around = np.concatenate([goal[None], *paths])
    grid, scales = grid_over([around], obstacles, scales)
    speed = experience_map(
        grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
    )
    speed = add_obstacles(speed, grid, obstacles, area_of_influence=scales.clearance)
    cell = grid.cells_of(goal[None])
    if speed[tuple(cell[0])] == 0.0:
        raise NoPath(f"goal: {goal} lies in an obstacle", reason="goal_in_wall")
    return grid, arrival_times(speed, cell, spacing=grid.spacing)


def grid_over(
    points: Sequence[Float64Array], obstacles: Sequence[Shape], scales: Scales
) -> tuple[Grid, Scales]:
    """A grid around points, and the scales made definite for it.

    It leaves room to go around those obstacles that lie among the points.

    Args:
        points: arrays (n, d).
        obstacles: shapes in the same frame.
        scales: of the map; a resolution of None is chosen here.

    Raises:
        InvalidInput: if the grid would be too large, or the points leave a workspace that was set.
    """
    corners, margin = _bounds(np.concatenate(points), obstacles, scales)
    resolution = scales.resolution
    if resolution is None:
        sides = np.ptp(corners, axis=0) + 2.0 * margin
        coarsest = float((sides.prod() / _MOST_DEFAULT_CELLS) ** (1.0 / len(sides)))
        widest = scales.growth * scales.radius / _LEAST_CELLS_PER_RADIUS
        resolution = min(max(scales.radius / _CELLS_PER_RADIUS, coarsest), widest)
    radius = max(scales.radius, _LEAST_CELLS_PER_RADIUS * resolution)
    grid = Grid.covering(corners, margin=margin, spacing=resolution)
    return grid, replace(scales, radius=radius, resolution=resolution)


def _bounds(
    points: Float64Array, obstacles: Sequence[Shape], scales: Scales
) -> tuple[Float64Array, float]:
    """Points that the grid covers and the margin around them. Raises InvalidInput."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    if scales.workspace is not None:
        corners = check.array(scales.workspace, "workspace", shape=(2, len(lower)))
        if (lower < corners[0]).any() or (upper > corners[1]).any():
            raise InvalidInput(
                f"workspace: expected corners around demonstrations, start and goal, {lower} to "
                f"{upper}, got {corners[0]} to {corners[1]}"
            )
        return corners, 0.0
    extent = float((upper - lower).max())
    margin = _MARGIN * scales.radius
    if obstacles:
        margin = max(margin, _ROOM * extent)
    return np.stack([lower, upper, *_obstacle_corners(obstacles, lower, upper, extent)]), margin


def _obstacle_corners(
    obstacles: Sequence[Shape], lower: Float64Array, upper: Float64Array, extent: float
) -> list[Float64Array]:
    """Corners of the boxes around those obstacles that reach between lower and upper.

    Clipped to one extent beyond them: a floor that goes on for ever must not fill the grid.
    """
    corners = []
    for obstacle in obstacles:
        centre, reach = obstacle.position[: len(lower)], bounding_radius(obstacle)
        if (centre + reach >= lower).all() and (centre - reach <= upper).all():
            corners.append(np.maximum(centre - reach, lower - extent))
            corners.append(np.minimum(centre + reach, upper + extent))
    return corners


def _nearness(starts: Float64Array, start: Float64Array) -> Float64Array:
    """Weights (k,), 1 for the nearest start: far from all of them it still counts in full."""
    apart = np.linalg.norm(starts[:, None] - starts[None], axis=2)
    pairs = apart[np.triu_indices(len(starts), 1)]
    if len(starts) == 1 or pairs.mean() == 0.0:
        return np.ones(len(starts))
    squared = ((starts - start) ** 2).sum(axis=1)
    width = _START_WIDTH * float(pairs.mean())
    return np.asarray(np.exp(-(squared - squared.min()) / (2.0 * width**2)))


def _along_tube(mean: Float64Array, grid: Grid, free: Float64Array, scales: Scales) -> Float64Array:
    """The path through the tube around a mean path, piece by piece. Raises NoPath.

    It makes a detour where `free`, the obstacles' factor on the speed, is below 1 on the way.
    """
    influenced = free[tuple(grid.cells_of(mean).T)] < 1.0
    parts = []
    try:
        for stretch, blocked in _stretches(mean, influenced):
            if blocked:
                # As wide a tube as the detour may become: it leaves and rejoins the path gently.
                wide = replace(scales, radius=0.5 * float(arc_length(stretch)[-1]))
                speed = free * _tube(stretch, grid, wide)
                parts.append(quickest(grid, speed, stretch[0], stretch[-1]))
                continue
            for piece in cut_at_short_cuts(
                stretch, radius=scales.radius, saturation=scales.saturation
            ):
                parts.append(quickest(grid, _tube(piece, grid, scales), piece[0], piece[-1]))
    except NoPath:
        # An end of a detour may be enclosed although start and goal are not.
        parts = [quickest(grid, free * _tube(mean, grid, scales), mean[0], mean[-1])]
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def _tube(path: Float64Array, grid: Grid, scales: Scales) -> Float64Array:
    return tube_map(
        grid, [path], [1.0], area_of_influence=scales.radius, saturation=scales.saturation
    )


def _stretches(
    path: Float64Array, influenced: NDArray[np.bool_]
) -> list[tuple[Float64Array, bool]]:
    """Consecutive parts of a path (n, d) and whether each is a detour around an obstacle.

    influenced: (n,). A detour begins and ends half its obstacle's stretch early and late, so that
    there is way to leave the path and to come back. Neighbours share their end point.
    """
    blocked = np.zeros(len(path), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], influenced, [0]])))
    for first, end in edges.reshape(-1, 2):
        extra = (end - first + 1) // 2
        blocked[max(first - extra, 0) : end + extra] = True
    changes = np.flatnonzero(np.diff(blocked)) + 1
    bounds = [0, *(int(change) for change in changes), len(path) - 1]
    return [
        (path[a : b + 1], bool(blocked[a])) for a, b in pairwise(bounds) if b > a or len(path) == 1
    ]


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
) -> Route:
    """A path made smooth where obstacles allow, with the map's speed along it.

    Args:
        path: (n, d).
        grid: cells of the map.
        speed: in each cell, 0 in obstacles.
        used: the demonstrations that it follows.
        weights: (k,) how much each one's timing counts.
        method: the method that found it.
    """
    walls = speed == 0.0
    smoothed = smooth_path(
        path,
        knot_spacing=_CELLS_PER_KNOT * float(grid.spacing.max()),
        accept=lambda points: not walls[tuple(grid.cells_of(points).T)].any(),
    )
    along = map_coordinates(
        speed, grid.coordinates(smoothed).T, np.float64, order=1, mode="nearest"
    )
    # Between a free cell and a wall the interpolated speed may vanish; a path never stands still.
    slowest = float(speed[~walls].min())
    return Route(smoothed, np.maximum(along, slowest), used, weights, method)
