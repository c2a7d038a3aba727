"""Obstacles as the walls of a grid, looked up where they are asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.planning.blocks import Blocks, Numbers
from leadthrough.planning.grid import Grid
from leadthrough.shapes import Shape


class Walls:
    """The cells whose centre lies in an obstacle, or so near that a path may touch it.

    Args:
        grid: the cells; a 2-D grid is the plane z = 0.
        obstacles: shapes in the grid's unit.
    """

    def __init__(self, grid: Grid, obstacles: Sequence[Shape]) -> None:
        self.grid = grid
        self._obstacles = [(each, each.middle, each.half_extents) for each in obstacles]
        # A path may pass a free cell's corner, half a diagonal from the centre that is tested.
        self._margin = 0.5 * float(np.linalg.norm(grid.spacing))

    def hold(self, cells: Numbers) -> NDArray[np.bool_]:
        """Whether each cell is a wall, (n,)."""
        return self._are_walls(Blocks(self.grid, 0).centres(cells))

    def distances(self, cells: Numbers, most: float) -> Float64Array:
        """Distances (n,) to the nearest wall, centre to centre, at most `most`; 0 in walls.

        Args:
            cells: ascending.
            most: in the grid's unit, > 0.
        """
        nearest = self._to_obstacles(Blocks(self.grid, 0).centres(cells), most + self._margin)
        result = np.where(nearest <= self._margin, 0.0, most)
        beside = (nearest > self._margin) & (nearest < most + self._margin)
        if beside.any():
            shape, spacing = self.grid.shape, self.grid.spacing.tolist()
            asked = np.ascontiguousarray(cells[beside])
            around = _core.cells_within(shape, spacing, asked, most)
            found = _core.CellSet(shape, spacing, around)
            result[beside] = found.distances(self.hold(around))[found.find(asked)]
        return np.minimum(result, most)

    def farthest(self, blocks: Blocks, numbers: Numbers, most: float) -> Float64Array:
        """Upper bounds (n,) of `distances` over the cells of blocks; 0 where all are walls.

        Args:
            blocks: of the same grid.
            numbers: of the blocks.
            most: as in `distances`.
        """
        nearest = self._to_obstacles(blocks.centres(numbers), most) + blocks.reach
        # The cell that holds an obstacle's nearest point is a wall, its centre a margin away.
        return np.where(nearest <= self._margin, 0.0, np.minimum(nearest + self._margin, most))

    def nearest(self, blocks: Blocks, numbers: Numbers, most: float) -> Float64Array:
        """Lower bounds (n,) of `distances` over the cells of blocks, which may be negative.

        Args:
            blocks: of the same grid.
            numbers: of the blocks.
            most: as in `distances`.
        """
        room = most + self._margin + blocks.reach
        return self._to_obstacles(blocks.centres(numbers), room) - self._margin - blocks.reach

    def _are_walls(self, points: Float64Array) -> NDArray[np.bool_]:
        return self._to_obstacles(points, 2.0 * self._margin) <= self._margin

    def _to_obstacles(self, points: Float64Array, most: float) -> Float64Array:
        """Signed distances (n,) of points (n, d) to the nearest obstacle, at most `most`."""
        result = np.full(len(points), most)
        if points.shape[1] == 2:
            points = np.column_stack([points, np.zeros(len(points))])
        for obstacle, middle, half in self._obstacles:
            # Axis by axis: NumPy is many times slower where it reduces over three.
            near = np.abs(points[:, 0] - middle[0]) - half[0] < result
            for axis in (1, 2):
                near &= np.abs(points[:, axis] - middle[axis]) - half[axis] < result
            if near.all():
                result = np.minimum(result, obstacle.distance(points))
            elif near.any():
                result[near] = np.minimum(result[near], obstacle.distance(points[near]))
        return result
