"""Obstacles on a grid, and speed maps: paths prefer to go where the wave runs fast.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1 and eq. 7. Distances are exact Euclidean
ones, where the paper marches a wave at unit speed; both are the distance to the tube's border.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoPath
from leadthrough.planning.grid import (
    MAX_CELLS,
    CellArray,
    CellNumbers,
    Grid,
    bounds_of,
    check_grid,
    spacings,
)
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.shapes import Shape, check_shapes, compiled


def occupied(grid: Grid, obstacles: Iterable[Shape], *, margin: float = 0.0) -> NDArray[np.bool_]:
    """Mask, grid.shape, of the cells whose centre is in an obstacle or nearer than a margin.

    Args:
        grid: the cells; a 2-D grid is the plane z = 0.
        obstacles: shapes.
        margin: in the grid's unit, >= 0.
    """
    room = check.number(margin, "margin", at_least=0.0)
    result = np.zeros(check_grid(grid).shape, dtype=np.bool_)
    for obstacle in check_shapes(obstacles):
        near = _neighbourhood(grid, obstacle, room)
        if all(part.stop > part.start for part in near):
            result[near] |= _distances_of_cells(grid, near, obstacle) <= room
    return result


def occupied_by_points(grid: Grid, points: ArrayLike, *, radius: float) -> NDArray[np.bool_]:
    """Mask, grid.shape, of the cells whose centre is within a radius of a point of a cloud.

    Args:
        points: (n, d), in the grid's unit; those outside the grid count as far as they reach into
            it.
        radius: in the grid's unit, > 0; below half a cell's diagonal a point may lie between all
            centres.
    """
    from scipy.spatial import cKDTree

    check_grid(grid)
    cloud = check.array(points, "points", shape=("n", grid.dimensions))
    reach = check.number(radius, "radius", above=0.0)
    if len(cloud) == 0:
        return np.zeros(grid.shape, dtype=np.bool_)
    # A point is half a diagonal at most from the centre of its cell: only cells that near the
    # sphere around that centre have to be searched. The reach of a point outside the
    # grid lies within that of the grid's point nearest to it.
    slack = 0.5 * float(np.linalg.norm(grid.spacing))
    last = grid.origin + grid.spacing * (np.array(grid.shape) - 1)
    result = _distance_to_cells(grid, cloud[grid.contains(cloud)]) <= reach - slack
    asked = _distance_to_cells(grid, np.clip(cloud, grid.origin, last)) <= reach + slack
    asked &= ~result
    centres = grid.points_at(np.argwhere(asked))
    result[asked] = cKDTree(cloud).query(centres)[0] <= reach
    return result


def _distance_to_cells(grid: Grid, points: Float64Array) -> Float64Array:
    cells = np.zeros(grid.shape, dtype=np.bool_)
    cells[tuple(grid.cells_of(points).T)] = True
    return distance_transform(cells, spacing=grid.spacing)


def _neighbourhood(grid: Grid, obstacle: Shape, room: float) -> tuple[slice, ...]:
    """The cells that the obstacle's bounding box reaches, with room on all sides."""
    d = grid.dimensions
    reach = obstacle.half_extents[:d] + room
    offset = (obstacle.middle[:d] - grid.origin) / grid.spacing
    low = np.clip(np.floor(offset - reach / grid.spacing), 0, grid.shape)
    high = np.clip(np.ceil(offset + reach / grid.spacing) + 1, 0, grid.shape)
    return tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))


def _distances_of_cells(grid: Grid, near: tuple[slice, ...], obstacle: Shape) -> Float64Array:
    """Distances of the centres of a box of cells to an obstacle."""
    axes = [
        start + step * np.arange(part.start, part.stop)
        for start, step, part in zip(grid.origin, grid.spacing, near, strict=True)
    ]
    if grid.dimensions == 2:
        axes.append(np.zeros(1))
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return obstacle.distance(points).reshape([part.stop - part.start for part in near])


def distance_transform(mask: ArrayLike, *, spacing: ArrayLike = 1.0) -> Float64Array:
    """Distance of every cell to the nearest True cell, centre to centre; inf if there is none.

    Args:
        mask: 2-D or 3-D booleans.
        spacing: distance between neighbouring cells, > 0, (d,) or one number.

    Returns:
        Distances in the unit of the spacing, of the mask's shape.
    """
    cells = check.regular(mask, "mask")
    if cells.dtype != np.bool_ or cells.ndim not in (2, 3) or not 0 < cells.size <= MAX_CELLS:
        raise InvalidInput(
            f"mask: expected a 2-D or 3-D array of booleans with 1 to {MAX_CELLS:.0e} cells, "
            f"got shape {cells.shape} of {cells.dtype}"
        )
    steps = spacings(spacing, cells.ndim).tolist()
    with check.enough_memory(f"mask: a grid of shape {cells.shape}"):
        return core.distance_transform(np.ascontiguousarray(cells), steps)


class Walls:
    """Cells whose centre lies in an obstacle, or so near that a path could touch it.

    Args:
        grid: the cells; a 2-D grid is the plane z = 0.
        obstacles: shapes in the grid's unit.

    Attributes:
        compiled: the walls as the compiled core takes them.
    """

    def __init__(self, grid: Grid, obstacles: Sequence[Shape]) -> None:
        # A path may pass a free cell's corner, half a diagonal from the centre that is tested.
        margin = 0.5 * float(np.linalg.norm(grid.spacing))
        middles = np.array([each.middle for each in obstacles]).reshape(-1, 3)
        extents = np.array([each.half_extents for each in obstacles]).reshape(-1, 3)
        shapes = compiled(obstacles)
        self.compiled = core.Walls(grid.compiled, margin, shapes, middles, extents)

    def distances(self, cells: CellNumbers, most: float) -> Float64Array:
        """Distances (n,) to the nearest wall, centre to centre, at most `most`; 0 in walls.

        Args:
            cells: numbers of cells, ascending.
            most: in the grid's unit, > 0.
        """
        return self.compiled.distances(cells, most)


Speeds = TypeVar("Speeds", NDArray[np.float32], NDArray[np.float64])

ROUNDING = 1e-9
# Cells faster than the saturation by more than this fraction lie in a tube; float32 is coarser
# than the speeds themselves.
IN_TUBE = 1e-6


def experience_map(
    grid: Grid, paths: Sequence[Float64Array], *, area_of_influence: float, saturation: float
) -> Float64Array:
    """Speeds of grid.shape: 1 deepest in the tube around the paths, the saturation outside it."""
    labelled = np.zeros(grid.shape, dtype=bool)
    for path in paths:
        labelled[tuple(grid.cells_of(fine_samples(path, grid)).T)] = True
    # Radii are often whole numbers of cells: rounding must not decide which cells belong.
    reach = area_of_influence * (1.0 + ROUNDING)
    tube = distance_transform(labelled, spacing=grid.spacing) <= reach
    depth = distance_transform(~tube, spacing=grid.spacing)
    deepest = depth.max()
    if deepest == 0.0 or np.isinf(deepest):  # no experience, or experience everywhere
        return np.full(grid.shape, saturation if deepest == 0.0 else 1.0)
    return np.asarray(saturation + (1.0 - saturation) * depth / deepest)


def add_obstacles(
    speed: Speeds, grid: Grid, obstacles: Sequence[Shape], *, area_of_influence: float
) -> Speeds:
    """The speed map with walls (speed 0) at the obstacles and slower cells beside them.

    The product with the obstacles' own map: the speed grows from 0 at an obstacle to its own value
    one area of influence away, so that a path keeps that distance wherever there is room.
    """
    part, beside = _beside(grid, obstacles, area_of_influence)
    if part is None:
        return speed
    result = speed.copy()
    result[part] *= beside
    return result


def add_passable_obstacles(
    speed: Speeds,
    grid: Grid,
    obstacles: Sequence[Shape],
    *,
    band: float,
    saturation: float,
    reach: float,
) -> Speeds:
    """The speed map with walls at obstacles, slower cells beside them and detours around them."""
    part, beside = _beside(grid, obstacles, 2.0 * band)
    if part is None:
        return speed
    result = speed.copy()
    struck = (beside == 0.0) & (result[part] > saturation * (1.0 + IN_TUBE))
    if struck.any():
        near = distance_transform(struck, spacing=grid.spacing) <= reach
        closeness = np.where(near, 1.0 - np.abs(2.0 * beside - 1.0), 0.0)
        result[part] = np.maximum(result[part], saturation + (1.0 - saturation) * closeness)
    result[part] *= np.minimum(2.0 * beside, 1.0)
    return result


def add_saturated_obstacles(
    speed: Speeds,
    grid: Grid,
    obstacles: Sequence[Shape],
    *,
    area_of_influence: float,
    saturation: float,
) -> Speeds:
    """The speed map with walls at the obstacles and slower cells close beside them.

    The smaller of both maps where that of the obstacles is below the saturation, and the map
    unchanged elsewhere. The step in the speed between them may show in a path as a corner.

    Args:
        area_of_influence: distance over which the obstacles' own map grows from 0 to 1, in the
            grid's unit.
        saturation: in (0, 1].

    Source: Prados et al. 2023, eq. 7.
    """
    part, beside = _beside(grid, obstacles, area_of_influence)
    if part is None:
        return speed
    result = speed.copy()
    low = beside < saturation
    result[part][low] = np.minimum(result[part], beside)[low]
    return result


def _beside(
    grid: Grid, obstacles: Sequence[Shape], area_of_influence: float
) -> tuple[tuple[slice, ...] | None, Float64Array]:
    """The obstacles' own map, 0 in them to 1 one area of influence away, and where it is not 1."""
    # A path may pass a free cell's corner, half a diagonal from the centre that was tested.
    walls = occupied(grid, obstacles, margin=0.5 * float(np.linalg.norm(grid.spacing)))
    if not walls.any():
        return None, np.ones(0)
    part = _around(walls, grid, area_of_influence)
    distance = distance_transform(walls[part], spacing=grid.spacing)
    return part, np.minimum(distance / area_of_influence, 1.0)


def _around(cells: NDArray[np.bool_], grid: Grid, radius: float) -> tuple[slice, ...]:
    """The box of cells that holds all True ones, of which there are some, and a radius around."""
    part = bounds_of(cells)
    assert part is not None
    reach = np.ceil(radius / grid.spacing).astype(np.int64)
    return tuple(
        slice(max(piece.start - int(more), 0), piece.stop + int(more))
        for piece, more in zip(part, reach, strict=True)
    )


def fine_samples(path: Float64Array, grid: Grid) -> Float64Array:
    """The path sampled finely enough to label every cell it crosses, except clipped corners."""
    if len(path) < 2:
        return path
    steps = int(np.ceil(2.0 * arc_length(path)[-1] / np.min(grid.spacing))) + 1
    return by_arc_length(path, max(steps, 2))


class SpeedField:
    """Speeds of the cells of a grid.

    Attributes:
        grid: of the cells.
        outside: speed beyond the grid, where there are no walls; 0 where no wave goes there.
        compiled: the speeds as the compiled core takes them.
    """

    def __init__(self, grid: Grid, outside: float, compiled: core.SpeedMap) -> None:
        self.grid, self.outside, self.compiled = grid, outside, compiled

    def at(self, cells: CellNumbers) -> Float64Array:
        """Speeds (n,) of cells, which are ascending; 0 in walls."""
        return self.compiled.at(cells)

    def fastest(self, level: int, blocks: CellNumbers) -> Float64Array:
        """Upper bounds (n,) of the speeds of the cells of blocks; 0 where all are walls.

        Args:
            level: a block is 2^level cells wide.
            blocks: numbers (n,) in C order, ascending, counted from the first cell.
        """
        return self.compiled.fastest(level, blocks)


def speeds_at(field: SpeedField, cells: CellArray) -> Float64Array:
    """Speeds (n,) of cells (n, d) in any order."""
    asked, of = np.unique(field.grid.numbers_of(cells), return_inverse=True)
    return field.at(asked)[of]


class MapField(SpeedField):
    """The speeds of a map that is there already."""

    def __init__(self, grid: Grid, speed: NDArray[Any]) -> None:
        speeds = np.ascontiguousarray(speed, dtype=np.float64)
        super().__init__(grid, 0.0, core.given_speeds(grid.compiled, 0.0, speeds))


class FreeField(SpeedField):
    """Speeds without obstacles, above a saturation in tubes around paths only."""

    compiled: core.FreeSpeedMap


class ExperienceField(FreeField):
    """The speeds of `experience_map`, from its arguments."""

    def __init__(
        self,
        grid: Grid,
        paths: Sequence[Float64Array],
        *,
        area_of_influence: float,
        saturation: float,
    ) -> None:
        fine = [fine_samples(path, grid) for path in paths]
        speeds = core.experience_speeds(grid.compiled, saturation, fine, area_of_influence)
        super().__init__(grid, saturation, speeds)


class TubeField(FreeField):
    """Speeds that fall linearly from weight_j on path j to the saturation outside its tube."""

    def __init__(
        self,
        grid: Grid,
        paths: Sequence[Float64Array],
        weights: Sequence[float] | Float64Array,
        *,
        area_of_influence: float,
        saturation: float,
    ) -> None:
        fine = [fine_samples(path, grid) for path in paths]
        plain = [float(weight) for weight in weights]
        speeds = core.tube_speeds(grid.compiled, saturation, fine, plain, area_of_influence)
        super().__init__(grid, saturation, speeds)


class ObstacleField(SpeedField):
    """The speeds of `add_obstacles`: a field without obstacles times their distances."""

    def __init__(self, free: SpeedField, walls: Walls, *, area_of_influence: float) -> None:
        speeds = core.hindered_speeds(free.compiled, walls.compiled, area_of_influence)
        super().__init__(free.grid, free.outside, speeds)


class SaturatedField(SpeedField):
    """The speeds of `add_saturated_obstacles`, eq. 7 of the paper."""

    def __init__(
        self, free: SpeedField, walls: Walls, *, area_of_influence: float, saturation: float
    ) -> None:
        speeds = core.saturated_speeds(free.compiled, walls.compiled, area_of_influence, saturation)
        super().__init__(free.grid, free.outside, speeds)


class DetourField(SpeedField):
    """The speeds of `add_passable_obstacles`; the saturation is that of the free field."""

    def __init__(self, free: FreeField, walls: Walls, *, band: float, reach: float) -> None:
        speeds = core.passable_speeds(free.compiled, walls.compiled, band, reach)
        super().__init__(free.grid, free.outside, speeds)


def quickest(field: SpeedField, start: Float64Array, goal: Float64Array) -> Float64Array:
    """The path (n, d) of least time, the same as in a march through the whole map.

    Its cost grows with the path, not with the map. One of the ends may lie outside the grid: the
    path is straight between it and the first cell.

    Args:
        field: speeds in cells.
        start: (d,).
        goal: (d,).

    Raises:
        NoPath: if an end lies in an obstacle, or obstacles separate them.
    """
    with check.enough_memory(f"resolution: a grid of shape {field.grid.shape}"):
        status, path = field.compiled.quickest(start.tolist(), goal.tolist())
    if status == "separated":
        raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
    if status != "found":
        name, point = ("start", start) if status == "start_in_wall" else ("goal", goal)
        raise NoPath(f"{name}: {point} lies in an obstacle", reason=status)
    return path
