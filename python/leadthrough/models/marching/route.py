"""Paths between two points that follow demonstrations, planned in a speed map of them.

`through_map`: Algorithm 1 of Prados et al. 2023, all demonstrations in one map. `from_start`: the
demonstrations count by how near they start. The module `along_mean` has the third way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.extent import MOST_CELLS_FROM_AFAR, covered_ends, grid_over
from leadthrough.models.marching.hindrance import hindered_field, passable_field
from leadthrough.models.marching.outside import clear_outside, smooth_between_walls
from leadthrough.models.marching.query import Query
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.band import quickest
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_field import (
    ExperienceField,
    FreeField,
    SpeedField,
    TubeField,
    speeds_at,
)
from leadthrough.preprocess.resample import arc_length
from leadthrough.repr import ShortRepr

# Grid noise is shorter than this many cells; the shapes of demonstrations are not.
CELLS_PER_KNOT = 8.0
# Width of the weights over the demonstrations' starts, in their mean distance from each other.
_START_WIDTH = 0.25


@dataclass(frozen=True, eq=False)
class Route(ShortRepr):
    """A path and how it was found."""

    path: Float64Array  # (n, d), dense and smooth
    speed: Float64Array  # (n,) the map's speed along it, in (0, 1]
    used: tuple[Experience, ...]  # the demonstrations that it follows, facing its way
    weights: Float64Array  # (k,) how much each one's timing counts
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
    """The quickest path in the map of demonstrations."""
    mapped = known if useful is None else useful
    paths = [each.way for each in mapped]

    def free(grid: Grid, scales: Scales) -> FreeField:
        return ExperienceField(
            grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
        )

    used = tuple(each.facing(query.start, query.goal) for each in mapped or known)
    path, around = _through(free, paths, query, scales)
    return route_along(path, around, used=used, weights=np.ones(len(used)), method="map")


def from_start(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The quickest path in a map where demonstrations count by how near they start."""
    used = tuple(each.facing(query.start, query.goal) for each in known)
    weights = _nearness(np.stack([each.path[0] for each in used]), query.start)
    paths = [each.way for each in used]

    def free(grid: Grid, scales: Scales) -> FreeField:
        return TubeField(
            grid, paths, weights, area_of_influence=scales.radius, saturation=scales.saturation
        )

    path, around = _through(free, paths, query, scales)
    return route_along(path, around, used=used, weights=weights, method="start")


def _through(
    free: Callable[[Grid, Scales], FreeField],
    paths: Sequence[Float64Array],
    query: Query,
    scales: Scales,
) -> tuple[Float64Array, SpeedField]:
    """The quickest path (n, d) of a query, and the map with its obstacles."""
    *near, everything = covered_ends(paths, query.ends, scales)
    for ends in near:
        grid, own = grid_over(
            [*paths, ends], query.obstacles, scales, most_cells=MOST_CELLS_FROM_AFAR
        )
        field = free(grid, own)
        try:
            path = quickest(passable_field(field, query.obstacles, own), query.start, query.goal)
        except NoPath:  # beyond the grid there may be a way
            break
        if clear_outside(path, grid, query.obstacles, own.clearance):
            return path, hindered_field(field, query.obstacles, own)
    grid, own = grid_over([*paths, everything], query.obstacles, scales)
    field = free(grid, own)
    path = quickest(passable_field(field, query.obstacles, own), query.start, query.goal)
    return path, hindered_field(field, query.obstacles, own)


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
    spacing = knot_spacing or CELLS_PER_KNOT * float(field.grid.spacing.max())
    smoothed = smooth_between_walls(path, field, spacing)
    if region is not None:
        smoothed = np.clip(smoothed, *region)
    return Route(smoothed, _between_cells(field, smoothed), used, weights, method)


def _between_cells(field: SpeedField, points: Float64Array) -> Float64Array:
    """Speeds (n,) at points (n, d), multilinear between the centres of cells."""
    inside = field.grid.contains(points)
    if not inside.all():
        result = np.full(len(points), field.outside)
        result[inside] = _between_cells(field, points[inside])
        return result
    last = np.array(field.grid.shape) - 1
    places = np.clip(field.grid.coordinates(points), 0.0, last)
    low = np.floor(places).astype(np.int64)
    corners = np.array(list(product((0, 1), repeat=len(last))))
    parts = np.where(corners[:, None], places - low, 1.0 - (places - low))
    cells = np.minimum(low + corners[:, None], last)
    speeds = speeds_at(field, cells.reshape(-1, len(last))).reshape(cells.shape[:2])
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
