"""The grid that a map of demonstrations is made on, and the scales made definite for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.grid import Grid
from leadthrough.shapes import Shape

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
