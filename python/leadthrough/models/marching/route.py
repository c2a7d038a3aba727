"""Routes between two points that follow demonstrations, planned in a speed map of them.

`through_map`: Algorithm 1 of Prados et al. 2023, all demonstrations in one map. `from_start`: the
demonstrations count by how near they start. The module `mean_path` has the third kind. `LiveMap`
keeps one map, in which a query marches no farther than to its start.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoPath, ShortRepr
from leadthrough.models.marching.experience import Experience
from leadthrough.motion import Target
from leadthrough.planning import Grid, arrival_times, descend, maps, speed_map
from leadthrough.planning.maps import Scales, with_obstacles
from leadthrough.planning.speed_map import FreeField, MapField, SpeedField, quickest
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Shape, check_shapes

# Width of the weights over the demonstrations' starts, in their mean distance from each other.
_START_WIDTH = 0.25


@dataclass(frozen=True, eq=False)
class Query:
    """Start, goal and obstacles of a path."""

    start: Float64Array  # (d,)
    goal: Float64Array  # (d,)
    obstacles: tuple[Shape, ...] = ()  # shapes in the same frame

    @property
    def ends(self) -> Float64Array:
        """Start and goal, (2, d)."""
        return np.stack([self.start, self.goal])


@dataclass(frozen=True, eq=False)
class Route(ShortRepr):
    """A path and how it was planned."""

    path: Float64Array  # (n, d), dense and smooth
    speed: Float64Array  # (n,) the map's speed along it, in (0, 1]
    used: tuple[Experience, ...]  # the demonstrations that it follows, in its direction
    weights: Float64Array  # (k,) how much each one's timing counts
    method: str
    leaves_nominal_route: bool = False

    @property
    def length(self) -> float:
        """Arc length of the path, in its unit."""
        return float(arc_length(self.path)[-1])

    @property
    def travel_time(self) -> float:
        """When a wave of the map's speed arrives at its end, in the path's unit."""
        steps = np.linalg.norm(np.diff(self.path, axis=0), axis=1)
        return float((steps * 0.5 * (1.0 / self.speed[1:] + 1.0 / self.speed[:-1])).sum())


def query_of(
    demonstrated: Sequence[Experience],
    start: Target | None,
    goal: Target | None,
    obstacles: tuple[Shape, ...] = (),
) -> Query:
    """The query of a user, completed by the means of the demonstrations' ends."""
    first = _end(demonstrated, split(demonstrated, start, "start")[0], "start", 0)
    last = _end(demonstrated, split(demonstrated, goal, "goal")[0], "goal", -1)
    if len(first) != len(last):
        raise InvalidInput(f"goal: expected shape {first.shape}, got {last.shape}")
    return Query(first, last, obstacles)


def split(
    demonstrated: Sequence[Experience], value: Any, name: str
) -> tuple[Any, Float64Array | None]:
    """A query's position, not checked yet, and its orientation (4,) if it has one."""
    of_poses = bool(demonstrated) and demonstrated[0].orientations is not None
    if not of_poses or not isinstance(value, tuple | list) or len(value) != 2:
        return value, None
    return value[0], check.quaternions(value[1], name, shape=(4,))


def through_map(
    known: Sequence[Experience],
    query: Query,
    scales: Scales,
    *,
    mapped: Sequence[Experience] | None = None,
) -> Route:
    """The quickest path in the map of demonstrations."""
    mapped = known if mapped is None else mapped
    paths = [each.denoised for each in mapped]

    def free(grid: Grid, scales: Scales) -> FreeField:
        return speed_map.ExperienceField(
            grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
        )

    used = tuple(each.towards(query.start, query.goal) for each in mapped or known)
    path, around = _through(free, paths, query, scales)
    return route_along(path, around, used=used, weights=np.ones(len(used)), method="map")


def from_start(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The quickest path in a map where demonstrations count by how near they start."""
    used = tuple(each.towards(query.start, query.goal) for each in known)
    weights = _nearness(np.stack([each.path[0] for each in used]), query.start)
    paths = [each.denoised for each in used]

    def free(grid: Grid, scales: Scales) -> FreeField:
        return speed_map.TubeField(
            grid, paths, weights, area_of_influence=scales.radius, saturation=scales.saturation
        )

    path, around = _through(free, paths, query, scales)
    return route_along(path, around, used=used, weights=weights, method="start")


def route_along(
    path: Float64Array,
    field: SpeedField,
    *,
    used: tuple[Experience, ...],
    weights: Float64Array,
    method: str,
    knot_spacing: float | None = None,
    region: tuple[Float64Array, Float64Array] | None = None,
) -> Route:
    """A path made smooth where obstacles allow, with the map's speed along it."""
    spacing = knot_spacing or maps.CELLS_PER_KNOT * float(field.grid.spacing.max())
    smoothed = maps.smooth_between_walls(path, field, spacing)
    if region is not None:
        smoothed = np.clip(smoothed, *region)
    return Route(smoothed, _between_cells(field, smoothed), used, weights, method)


class LiveMap:
    """The map of all demonstrations over a workspace; made by `FastMarchingSkill.live_map`."""

    def __init__(self, known: Sequence[Experience], scales: Scales) -> None:
        paths = [each.denoised for each in known]
        self._known = tuple(known)
        self._grid, speed, self._scales = maps.map_of(paths, scales)
        self._free = speed.astype(np.float32)

    @property
    def grid(self) -> Grid:
        return self._grid

    def route(self, start: Float64Array, goal: Float64Array, obstacles: Sequence[Shape]) -> Route:
        """The quickest path between two points around obstacles, in the map of the method "map"."""
        ends = [
            check.array(value, name, shape=(self._grid.dimensions,))
            for value, name in ((start, "start"), (goal, "goal"))
        ]
        for end, name in zip(ends, ("start", "goal"), strict=True):
            if not self._grid.contains(end[None])[0]:
                raise InvalidInput(f"{name}: expected a point inside the workspace, got {end}")
        shapes = check_shapes(obstacles)
        around = maps.with_detours(self._free, self._grid, shapes, self._scales)
        path = _quickest(self._grid, around, *ends)
        speed = MapField(self._grid, with_obstacles(self._free, self._grid, shapes, self._scales))
        used = tuple(each.towards(ends[0], ends[1]) for each in self._known)
        return route_along(path, speed, used=used, weights=np.ones(len(used)), method="map")


def _through(
    free: Callable[[Grid, Scales], FreeField],
    paths: Sequence[Float64Array],
    query: Query,
    scales: Scales,
) -> tuple[Float64Array, SpeedField]:
    """The quickest path (n, d) of a query, and the map with its obstacles."""
    *near, everything = maps.covered_ends(paths, query.ends, scales)
    for ends in near:
        grid, own = maps.grid_over(
            [*paths, ends], query.obstacles, scales, max_cells=maps.MAX_CELLS_FROM_AFAR
        )
        try:
            path, field = _quickest_on(free(grid, own), query, own)
        except NoPath:  # beyond the grid there may be a path
            break
        if maps.clear_outside(path, grid, query.obstacles, own.clearance):
            return path, field
    grid, own = maps.grid_over([*paths, everything], query.obstacles, scales)
    return _quickest_on(free(grid, own), query, own)


def _quickest_on(free: FreeField, query: Query, scales: Scales) -> tuple[Float64Array, SpeedField]:
    """The quickest path (n, d) in a map with detours around obstacles, and that without them."""
    passable = maps.detour_field(free, query.obstacles, scales)
    path = quickest(passable, query.start, query.goal)
    return path, maps.obstacle_field(free, query.obstacles, scales)


def _between_cells(field: SpeedField, points: Float64Array) -> Float64Array:
    """Speeds (n,) at points (n, d), multilinear between the centres of cells."""
    inside = field.grid.contains(points)
    if not inside.all():
        result = np.full(len(points), field.outside)
        result[inside] = _between_cells(field, points[inside])
        return result
    last = np.array(field.grid.shape) - 1
    at = np.clip(field.grid.coordinates(points), 0.0, last)
    low = np.floor(at).astype(np.int64)
    corners = np.array(list(product((0, 1), repeat=len(last))))
    parts = np.where(corners[:, None], at - low, 1.0 - (at - low))
    cells = np.minimum(low + corners[:, None], last)
    speeds = speed_map.speeds_at(field, cells.reshape(-1, len(last))).reshape(cells.shape[:2])
    along = (parts.prod(axis=2) * speeds).sum(axis=0)
    return np.asarray(np.maximum(along, speeds[speeds > 0.0].min()))


def _nearness(starts: Float64Array, start: Float64Array) -> Float64Array:
    """Weights (k,), 1 for the nearest start: far from all of them it still counts in full."""
    apart = np.linalg.norm(starts[:, None] - starts[None], axis=2)
    pairs = apart[np.triu_indices(len(starts), 1)]
    if len(starts) == 1 or pairs.mean() == 0.0:
        return np.ones(len(starts))
    squared = ((starts - start) ** 2).sum(axis=1)
    width = _START_WIDTH * float(pairs.mean())
    return np.asarray(np.exp(-(squared - squared.min()) / (2.0 * width**2)))


def _quickest(
    grid: Grid, speed: NDArray[np.float32], start: Float64Array, goal: Float64Array
) -> Float64Array:
    """The path (n, d) of least time in a map of speeds, at first order."""
    start_cell, goal_cell = grid.cells_of(np.stack([start, goal]))
    for name, point, cell in (("start", start, start_cell), ("goal", goal, goal_cell)):
        if speed[tuple(cell)] == 0.0:
            raise NoPath(f"{name}: {point} lies in an obstacle", reason=f"{name}_in_wall")
    arrival = arrival_times(
        speed, goal_cell, spacing=grid.spacing, order=1, dtype=np.float32, stop=start_cell
    )
    if np.isinf(arrival[tuple(start_cell)]):
        raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
    return descend(arrival, grid, start, goal)


def _end(
    demonstrated: Sequence[Experience], value: ArrayLike | None, name: str, index: int
) -> Float64Array:
    """A start or goal (d,), by default the mean of the demonstrations' points at an index."""
    if demonstrated:
        if value is None:
            return np.asarray(np.mean([each.path[index] for each in demonstrated], axis=0))
        return check.array(value, name, shape=(demonstrated[0].path.shape[1],))
    if value is None:
        raise InvalidInput(
            f"{name}: expected a point, as there is no demonstration to take it from"
        )
    point = check.array(value, name, shape=("d",))
    if len(point) not in (2, 3):
        raise InvalidInput(f"{name}: expected 2 or 3 coordinates, got {len(point)}")
    return point
