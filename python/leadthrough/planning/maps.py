"""Speed maps of demonstrations: lengths, grid and obstacles, and paths beside their walls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.planning import speed_map
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import FreeField, SpeedField, Speeds, TubeField, Walls, quickest
from leadthrough.preprocess import arc_length, by_arc_length
from leadthrough.preprocess.smooth import smooth_path
from leadthrough.shapes import Shape

# Grid noise is shorter than this many cells; the shapes of demonstrations are not.
CELLS_PER_KNOT = 8.0
_SATURATION = 0.02  # speed outside a tube
OBSTACLE_MAPS = ("product", "minimum")
# Radii in fractions of the demonstrations' mean length, so that the unit of the data does not
# matter. Tubes overlap in the map of all demonstrations; a tube around one path is thinner.
MAP_RADIUS = 0.02
TUBE_RADIUS = 0.01
# In three dimensions thin tubes need more cells than they are worth.
GROWTH = 3.0
# Maximum number of cells of a map for an end far away: the path to it may pass anywhere.
MAX_CELLS_FROM_AFAR = 500_000

_CELLS_PER_RADIUS = 5.0
# A tube of a thinner radius is not a tube.
_MIN_CELLS_PER_RADIUS = 2.0
# Beyond this many cells a default resolution gets coarser: 160 cubed, half a second to march.
_MAX_DEFAULT_CELLS = 4_000_000
# Room around everything, in radii, and around obstacles, as a fraction of the extent.
_MARGIN = 4.0
_ROOM = 0.25
# An end is far away at this distance from the demonstrations, in their extent.
_FAR = 1.0
# Width of the band in which the product slows the wave down, as a fraction of the clearance. A path
# that has to pass through a wider one beside its tube would rather leave the tube for a short cut.
_BAND = 0.5
# Reach of detours around an obstacle in a tube, in clearances: the tube continues beside small
# boxes, but not along a whole table that it touches.
_REACH = 2.0
# Length of the segment outside the map that is smoothed with the path inside, in knots: its corner
# at the map's border then vanishes.
_KNOTS = 6.0
# Points outside are farther apart by this factor: the path is straight there.
_SPARSER = 3.0
# Maximum number of points at which the map is looked up; two per cell otherwise.
_MAX_LOOKUPS = 100_000


@dataclass(frozen=True)
class Scales:
    """Lengths and speeds of a map; lengths in the demonstrations' unit."""

    radius: float  # of the tubes
    clearance: float  # distance from obstacles below which they slow the wave down
    saturation: float  # speed outside the tubes, in (0, 1]
    resolution: float | None
    growth: float = 1.0  # factor by which the tubes may become wider than the radius
    workspace: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    obstacle_map: str = "product"  # how obstacles enter the map, "product" or "minimum"


def scales_of(length: float) -> Scales:
    return Scales(TUBE_RADIUS * length, MAP_RADIUS * length, _SATURATION, None, growth=GROWTH)


def map_of(paths: Sequence[Float64Array], scales: Scales) -> tuple[Grid, Float64Array, Scales]:
    """A grid around paths, the speed map of the paths on it, and the scales made definite."""
    grid, scales = grid_over(paths, (), scales)
    return grid, speeds_along(paths, grid, scales), scales


def speeds_along(paths: Sequence[Float64Array], grid: Grid, scales: Scales) -> Float64Array:
    """Speeds of a grid: 1 deepest in the tube around paths, the saturation outside it."""
    return speed_map.experience_map(
        grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
    )


def grid_over(
    points: Sequence[Float64Array],
    obstacles: Sequence[Shape],
    scales: Scales,
    *,
    max_cells: int = _MAX_DEFAULT_CELLS,
) -> tuple[Grid, Scales]:
    """A grid around points, and the scales made definite for it."""
    corners, margin = _bounds(np.concatenate(points), obstacles, scales)
    resolution = scales.resolution
    if resolution is None:
        sides = np.ptp(corners, axis=0) + 2.0 * margin
        coarsest = float((sides.prod() / max_cells) ** (1.0 / len(sides)))
        widest = scales.growth * scales.radius / _MIN_CELLS_PER_RADIUS
        resolution = min(max(scales.radius / _CELLS_PER_RADIUS, coarsest), widest)
    radius = max(scales.radius, _MIN_CELLS_PER_RADIUS * resolution)
    grid = Grid.covering(corners, margin=margin, spacing=resolution)
    return grid, replace(scales, radius=radius, resolution=resolution)


def covered_ends(
    paths: Sequence[Float64Array], ends: Float64Array, scales: Scales
) -> Iterator[Float64Array]:
    """Ends (k, d) that a grid has to cover beside paths: first without one far away, then all."""
    if paths and scales.workspace is None:
        points = np.concatenate(paths)
        lower, upper = points.min(axis=0), points.max(axis=0)
        away = np.maximum(lower - ends, ends - upper).max(axis=1)
        farthest = int(np.argmax(away))
        if away[farthest] > _FAR * float((upper - lower).max()):
            yield np.delete(ends, farthest, axis=0)
    yield ends


def with_obstacles(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """A map of tubes with obstacles, as `FastMarching.obstacle_map` says."""
    if scales.obstacle_map == "minimum":
        return speed_map.add_saturated_obstacles(
            speed,
            grid,
            obstacles,
            area_of_influence=scales.clearance,
            saturation=scales.saturation,
        )
    return speed_map.add_obstacles(
        speed, grid, obstacles, area_of_influence=_BAND * scales.clearance
    )


def with_detours(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """The map of `with_obstacles` to plan in: the product has detours around obstacles."""
    if scales.obstacle_map == "minimum":
        return with_obstacles(speed, grid, obstacles, scales)
    return speed_map.add_passable_obstacles(
        speed,
        grid,
        obstacles,
        band=_BAND * scales.clearance,
        saturation=scales.saturation,
        reach=_REACH * scales.clearance,
    )


def obstacle_field(
    free: SpeedField, obstacles: Sequence[Shape], scales: Scales, *, band: float = _BAND
) -> SpeedField:
    """The speeds of `with_obstacles`, computed on demand."""
    if not obstacles:
        return free
    walls = Walls(free.grid, obstacles)
    if scales.obstacle_map == "minimum":
        return speed_map.SaturatedField(
            free, walls, area_of_influence=scales.clearance, saturation=scales.saturation
        )
    return speed_map.ObstacleField(free, walls, area_of_influence=band * scales.clearance)


def detour_field(free: FreeField, obstacles: Sequence[Shape], scales: Scales) -> SpeedField:
    """The speeds of `with_detours`, computed on demand."""
    if not obstacles or scales.obstacle_map == "minimum":
        return obstacle_field(free, obstacles, scales)
    return speed_map.DetourField(
        free,
        Walls(free.grid, obstacles),
        band=_BAND * scales.clearance,
        reach=_REACH * scales.clearance,
    )


def tube_field(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> SpeedField:
    """Speeds in a tube, and a whole clearance about obstacles: their product, or eq. 7."""
    free = TubeField(
        grid, [path], [1.0], area_of_influence=scales.radius, saturation=scales.saturation
    )
    return obstacle_field(free, obstacles, scales, band=1.0)


def quickest_in_tube(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> Float64Array:
    """The quickest path (n, d) between the ends of a path, in a tube around it."""
    return quickest(tube_field(path, grid, obstacles, scales), path[0], path[-1])


def slowed_at(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> NDArray[np.bool_]:
    """Whether obstacles slow the wave down at the points (n, d) of a path, (n,)."""
    limit = scales.saturation if scales.obstacle_map == "minimum" else 1.0
    cells, of = np.unique(grid.numbers_of(grid.cells_of(path)), return_inverse=True)
    beside = Walls(grid, obstacles).distances(cells, scales.clearance) / scales.clearance
    return np.asarray(beside[of] < limit)


def min_distance(path: Float64Array, obstacles: Sequence[Shape]) -> float:
    """Smallest distance between the points of a path (n, d) and obstacles; inf without any."""
    points = np.zeros((len(path), 3))
    points[:, : path.shape[1]] = path
    return min((float(each.distance(points).min()) for each in obstacles), default=np.inf)


def clear_outside(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], clearance: float
) -> bool:
    """Whether a path (n, d) keeps a clearance from obstacles outside a grid."""
    inside = grid.contains(path[[0, -1]])
    segments = [(path[0], path[1])] * (not inside[0]) + [(path[-1], path[-2])] * (not inside[1])
    return all(_is_clear(*each, obstacles, clearance) for each in segments)


def smooth_between_walls(
    path: Float64Array, field: SpeedField, knot_spacing: float
) -> Float64Array:
    """A path (n, d) made smooth as far as no wall is touched."""
    grid = field.grid
    inside = grid.contains(path[[0, -1]])
    if not inside[1]:
        return smooth_between_walls(path[::-1], field, knot_spacing)[::-1]

    def is_free(points: Float64Array) -> bool:
        cells = grid.cells_of(points[grid.contains(points)])
        return bool(speed_map.speeds_at(field, cells).all())

    if inside[0]:
        return smooth_path(path, knot_spacing=knot_spacing, accept=is_free)
    ahead = path[1] - path[0]
    straight = max(1.0 - _KNOTS * knot_spacing / float(np.linalg.norm(ahead)), 0.0)
    turn = path[0] + straight * ahead
    rest = smooth_path(
        np.concatenate([turn[None], path[1:]]), knot_spacing=knot_spacing, accept=is_free
    )
    step = float(arc_length(rest)[-1]) / (len(rest) - 1)
    count = int(np.ceil(float(np.linalg.norm(turn - path[0])) / (_SPARSER * step)))
    outside = path[0] + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (turn - path[0])
    return np.concatenate([outside, rest])


def mean_speed(path: Float64Array, grid: Grid, speed: Float64Array, outside: float) -> float:
    """The mean of a speed map along a path, evenly over its length (Prados et al. 2023, eq. 6)."""
    steps = 2.0 * float(arc_length(path)[-1]) / float(grid.spacing.min())
    points = by_arc_length(path, int(min(np.ceil(steps), _MAX_LOOKUPS)) + 2)
    inside = grid.contains(points)
    speeds = np.full(len(points), outside)
    speeds[inside] = speed[tuple(grid.cells_of(points[inside]).T)]
    return float(speeds.mean())


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


def _is_clear(
    start: Float64Array, end: Float64Array, obstacles: Sequence[Shape], clearance: float
) -> bool:
    """Whether a segment keeps the clearance, in steps as long as the free distance."""
    length = float(np.linalg.norm(end - start))
    at = 0.0
    while obstacles and at < length:
        point = np.zeros((1, 3))
        point[0, : len(start)] = start + (at / length) * (end - start)
        free = min(float(each.distance(point)[0]) for each in obstacles)
        if free < clearance:
            return False
        at += max(free - 0.5 * clearance, 0.5 * clearance)
    return True
