"""Obstacles on a grid."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.planning.grid import MAX_CELLS, CellNumbers, Grid, spacings
from leadthrough.shapes import Shape, check_shapes, compiled


def occupied(grid: Grid, obstacles: Iterable[Shape], *, margin: float = 0.0) -> NDArray[np.bool_]:
    """Mask, grid.shape, of the cells whose centre is in an obstacle or nearer than a margin.

    Args:
        grid: the cells; a 2-D grid is the plane z = 0.
        obstacles: shapes.
        margin: in the grid's unit, >= 0.
    """
    room = check.number(margin, "margin", at_least=0.0)
    result = np.zeros(grid.shape, dtype=np.bool_)
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
    cells = np.asarray(mask)
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
