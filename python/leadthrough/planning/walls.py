"""Obstacles as the walls of a grid, looked up where they are asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.planning.blocks import Blocks, Numbers
from leadthrough.planning.grid import Grid
from leadthrough.shapes import Shape, compiled


class Walls:
    """The cells whose centre lies in an obstacle, or so near that a path may touch it.

    Args:
        grid: the cells; a 2-D grid is the plane z = 0.
        obstacles: shapes in the grid's unit.
    """

    def __init__(self, grid: Grid, obstacles: Sequence[Shape]) -> None:
        self.grid = grid
        # A path may pass a free cell's corner, half a diagonal from the centre that is tested.
        margin = 0.5 * float(np.linalg.norm(grid.spacing))
        middles = np.array([each.middle for each in obstacles]).reshape(-1, 3)
        extents = np.array([each.half_extents for each in obstacles]).reshape(-1, 3)
        shapes = compiled(obstacles)
        self._walls = _core.Walls(Blocks(grid, 0).compiled, margin, shapes, middles, extents)

    def hold(self, cells: Numbers) -> NDArray[np.bool_]:
        """Whether each cell is a wall, (n,)."""
        return self._walls.hold(cells)

    def distances(self, cells: Numbers, most: float) -> Float64Array:
        """Distances (n,) to the nearest wall, centre to centre, at most `most`; 0 in walls.

        Args:
            cells: ascending.
            most: in the grid's unit, > 0.
        """
        return self._walls.distances(cells, most)

    def farthest(self, blocks: Blocks, numbers: Numbers, most: float) -> Float64Array:
        """Upper bounds (n,) of `distances` over the cells of blocks; 0 where all are walls.

        Args:
            blocks: of the same grid.
            numbers: of the blocks.
            most: as in `distances`.
        """
        return self._walls.farthest(blocks.compiled, numbers, most)

    def nearest(self, blocks: Blocks, numbers: Numbers, most: float) -> Float64Array:
        """Lower bounds (n,) of `distances` over the cells of blocks, which may be negative.

        Args:
            blocks: of the same grid.
            numbers: of the blocks.
            most: as in `distances`.
        """
        return self._walls.nearest(blocks.compiled, numbers, most)
