"""The grid that a map of demonstrations is made on, and the scales made definite for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import Grid
from leadthrough.planning.obstacles import Walls
from leadthrough.planning.speed_map import (
    FreeField,
    HinderedField,
    PassableField,
    SaturatedField,
    SpeedField,
    Speeds,
    add_obstacles,
    add_passable_obstacles,
    add_saturated_obstacles,
)
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.marching.model import FastMarching

_CELLS_PER_RADIUS = 5.0
# A tube of a thinner radius is not a tube.
_LEAST_CELLS_PER_RADIUS = 2.0
# Beyond this many cells a default resolution gets coarser: 160 cubed, half a second to march.
_MOST_DEFAULT_CELLS = 4_000_000
# And of a map that a way from far away leads into: it may lead anywhere, and is looked for widely.
MOST_CELLS_FROM_AFAR = 500_000
# Room around everything, in radii, and around obstacles, as a fraction of the extent.
_MARGIN = 4.0
_ROOM = 0.25
# An end is far away at this distance from the demonstrations, in their extent.
_FAR = 1.0


def covered_ends(
    paths: Sequence[Float64Array], ends: Float64Array, scales: Scales
) -> Iterator[Float64Array]:
    """Which ends (k, d) a grid has to cover, beside paths: first without one far away, then all."""
    if paths and scales.workspace is None:
        points = np.concatenate(paths)
        lower, upper = points.min(axis=0), points.max(axis=0)
        away = np.maximum(lower - ends, ends - upper).max(axis=1)
        farthest = int(np.argmax(away))
        if away[farthest] > _FAR * float((upper - lower).max()):
            yield np.delete(ends, farthest, axis=0)
    yield ends


def grid_over(
    points: Sequence[Float64Array],
    obstacles: Sequence[Shape],
    scales: Scales,
    *,
    most_cells: int = _MOST_DEFAULT_CELLS,
) -> tuple[Grid, Scales]:
    """A grid around points, and the scales made definite for it."""
    corners, margin = _bounds(np.concatenate(points), obstacles, scales)
    resolution = scales.resolution
    if resolution is None:
        sides = np.ptp(corners, axis=0) + 2.0 * margin
        coarsest = float((sides.prod() / most_cells) ** (1.0 / len(sides)))
        widest = scales.growth * scales.radius / _LEAST_CELLS_PER_RADIUS
        resolution = min(max(scales.radius / _CELLS_PER_RADIUS, coarsest), widest)
    radius = max(scales.radius, _LEAST_CELLS_PER_RADIUS * resolution)
    grid = Grid.covering(corners, margin=margin, spacing=resolution)
    return grid, replace(scales, radius=radius, resolution=resolution)


def _bounds(
    points: Float64Array, obstacles: Sequence[Shape], scales: Scales
) -> tuple[Float64Array, float]:
    """Points that the grid covers and the margin around them."""
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
    """Corners of the boxes around those obstacles that reach between lower and upper."""
    corners = []
    for obstacle in obstacles:
        centre, reach = obstacle.middle[: len(lower)], obstacle.bounding_radius
        if (centre + reach >= lower).all() and (centre - reach <= upper).all():
            corners.append(np.maximum(centre - reach, lower - extent))
            corners.append(np.minimum(centre + reach, upper + extent))
    return corners


# Radii in fractions of the demonstrations' mean length, so that the unit of the data does not
# matter. The map of all demonstrations wants tubes that overlap, a tube around one path a thin one.
MAP_RADIUS = 0.02
TUBE_RADIUS = 0.01
# In three dimensions thin tubes need more cells than they are worth.
_GROWTH = 3.0


@dataclass(frozen=True)
class Scales:
    """Lengths and speeds of a map; lengths in the demonstrations' unit."""

    radius: float  # of the tubes
    clearance: float  # distance from obstacles below which they slow the wave down
    saturation: float  # speed outside the tubes, in (0, 1]
    resolution: float | None
    growth: float = 1.0  # how much wider than the radius the tubes may become there
    workspace: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    obstacle_map: str = "product"  # how obstacles enter the map, "product" or "minimum"


def scales_of(model: FastMarching, lengths: Sequence[float], fraction: float) -> Scales:
    """The scales of a model's map."""
    given = model.area_of_influence
    length = float(np.mean(lengths))
    return Scales(
        radius=given or fraction * length,
        clearance=given or MAP_RADIUS * length,
        saturation=model.saturation,
        resolution=model.resolution,
        growth=1.0 if given else _GROWTH,
        workspace=model.workspace,
        obstacle_map=model.obstacle_map,
    )


OBSTACLE_MAPS = ("product", "minimum")

# Width of the band in which the product slows the wave down, as a fraction of the clearance. A path
# that has to pass through a wider one beside its tube would rather leave the tube for a short cut.
BAND = 0.5
# How far ways round an obstacle reach from where it stands in a tube, in clearances: the tube goes
# on beside small boxes, and not along a whole table that it touches.
REACH = 2.0


def hindered(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """A map of tubes with obstacles, as `FastMarching.obstacle_map` says."""
    if scales.obstacle_map == "minimum":
        return add_saturated_obstacles(
            speed,
            grid,
            obstacles,
            area_of_influence=scales.clearance,
            saturation=scales.saturation,
        )
    return add_obstacles(speed, grid, obstacles, area_of_influence=BAND * scales.clearance)


def passable(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """The map of `hindered` that paths are planned in: the product has ways round obstacles."""
    if scales.obstacle_map == "minimum":
        return hindered(speed, grid, obstacles, scales)
    return add_passable_obstacles(
        speed,
        grid,
        obstacles,
        band=BAND * scales.clearance,
        saturation=scales.saturation,
        reach=REACH * scales.clearance,
    )


def hindered_field(
    free: SpeedField, obstacles: Sequence[Shape], scales: Scales, *, band: float = BAND
) -> SpeedField:
    """The speeds of `hindered`, where they are asked for."""
    if not obstacles:
        return free
    walls = Walls(free.grid, obstacles)
    if scales.obstacle_map == "minimum":
        return SaturatedField(
            free, walls, area_of_influence=scales.clearance, saturation=scales.saturation
        )
    return HinderedField(free, walls, area_of_influence=band * scales.clearance)


def passable_field(free: FreeField, obstacles: Sequence[Shape], scales: Scales) -> SpeedField:
    """The speeds of `passable`, where they are asked for."""
    if not obstacles or scales.obstacle_map == "minimum":
        return hindered_field(free, obstacles, scales)
    return PassableField(
        free,
        Walls(free.grid, obstacles),
        band=BAND * scales.clearance,
        reach=REACH * scales.clearance,
    )
