"""Speeds of a map's cells, computed where they are asked for, however large the map is.

The maps of `speed_map`, cell by cell.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1 and eq. 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.planning.grid import CellArray, CellNumbers, Grid
from leadthrough.planning.speed_map import fine_samples
from leadthrough.planning.walls import Walls


class SpeedField:
    """Speeds of the cells of a grid.

    Attributes:
        grid: of the cells.
        outside: speed beyond the grid, where there are no walls; 0 where no wave goes there.
        compiled: the speeds as the compiled core takes them.
    """

    def __init__(self, grid: Grid, outside: float, compiled: _core.SpeedMap) -> None:
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

    def __init__(self, grid: Grid, speed: NDArray[Any], outside: float = 0.0) -> None:
        speeds = np.ascontiguousarray(speed, dtype=np.float64)
        super().__init__(grid, outside, _core.given_speeds(grid.compiled, outside, speeds))


class FreeField(SpeedField):
    """Speeds without obstacles, above a saturation in tubes around paths only."""

    compiled: _core.FreeSpeedMap


class ExperienceField(FreeField):
    """The speeds of `experience_map`.

    Args:
        grid: covers the paths.
        paths: each (n, d), in the grid's unit.
        area_of_influence: radius of the tube, in the grid's unit.
        saturation: in (0, 1].
    """

    def __init__(
        self,
        grid: Grid,
        paths: Sequence[Float64Array],
        *,
        area_of_influence: float,
        saturation: float,
    ) -> None:
        fine = [fine_samples(path, grid) for path in paths]
        speeds = _core.experience_speeds(grid.compiled, saturation, fine, area_of_influence)
        super().__init__(grid, saturation, speeds)


class TubeField(FreeField):
    """The speeds of `tube_map`.

    Args:
        grid: covers the paths.
        paths: each (n, d), in the grid's unit.
        weights: of each path, in [0, 1].
        area_of_influence: radius of the tubes, in the grid's unit.
        saturation: in (0, 1].
    """

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
        speeds = _core.tube_speeds(grid.compiled, saturation, fine, plain, area_of_influence)
        super().__init__(grid, saturation, speeds)


class HinderedField(SpeedField):
    """The speeds of `add_obstacles`: a field without obstacles times how far these are.

    Args:
        free: the field without obstacles.
        walls: of its grid.
        area_of_influence: in the grid's unit.
    """

    def __init__(self, free: SpeedField, walls: Walls, *, area_of_influence: float) -> None:
        speeds = _core.hindered_speeds(free.compiled, walls.compiled, area_of_influence)
        super().__init__(free.grid, free.outside, speeds)


class SaturatedField(SpeedField):
    """The speeds of `add_saturated_obstacles`, eq. 7 of the paper."""

    def __init__(
        self, free: SpeedField, walls: Walls, *, area_of_influence: float, saturation: float
    ) -> None:
        speeds = _core.saturated_speeds(
            free.compiled, walls.compiled, area_of_influence, saturation
        )
        super().__init__(free.grid, free.outside, speeds)


class PassableField(SpeedField):
    """The speeds of `add_passable_obstacles`, with ways round obstacles that stand in tubes.

    Args:
        free: the field without obstacles; its saturation is the speed outside the tubes.
        walls: of its grid.
        band: distance over which the speed grows from 0 at an obstacle to its own value.
        reach: of the ways round, from where an obstacle stands in a tube.
    """

    def __init__(self, free: FreeField, walls: Walls, *, band: float, reach: float) -> None:
        speeds = _core.passable_speeds(free.compiled, walls.compiled, band, reach)
        super().__init__(free.grid, free.outside, speeds)
