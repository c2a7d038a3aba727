"""Obstacles as the walls of a grid, looked up where they are asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.planning.grid import CellNumbers, Grid
from leadthrough.shapes import Shape, compiled


class Walls:
    """The cells whose centre lies in an obstacle, or so near that a path may touch it.

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
        self.compiled = _core.Walls(grid.compiled, margin, shapes, middles, extents)

    def distances(self, cells: CellNumbers, most: float) -> Float64Array:
        """Distances (n,) to the nearest wall, centre to centre, at most `most`; 0 in walls.

        Args:
            cells: numbers of cells, ascending.
            most: in the grid's unit, > 0.
        """
        return self.compiled.distances(cells, most)
