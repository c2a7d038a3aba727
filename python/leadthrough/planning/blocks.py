"""Blocks of a grid's cells: the same space in cells two, four, eight ... times as large."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.brief import Brief
from leadthrough.check import Float64Array
from leadthrough.planning.grid import CellArray, Grid

# Numbers of cells or blocks in C order, (n,).
Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Blocks(Brief):
    """Cubes of 2^level cells along each axis, counted from the grid's first cell.

    Attributes:
        grid: of the cells.
        level: 0 for the cells themselves.
    """

    grid: Grid
    level: int

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of blocks along every axis; the last ones may reach beyond the grid."""
        return tuple(-(-count >> self.level) for count in self.grid.shape)

    @cached_property
    def count(self) -> int:
        """Number of blocks in all."""
        return math.prod(self.shape)

    @cached_property
    def spacing(self) -> list[float]:
        """Distance between neighbours' centres along every axis."""
        return [float(step) * 2**self.level for step in self.grid.spacing]

    @cached_property
    def reach(self) -> float:
        """From a block's centre to the farthest centre of its cells."""
        return 0.5 * float((2**self.level - 1) * np.linalg.norm(self.grid.spacing))

    def centres(self, numbers: Numbers) -> Float64Array:
        """Centres (n, d) of blocks."""
        return self.compiled.centres(numbers)

    @cached_property
    def compiled(self) -> _core.Blocks:
        """The blocks as the compiled core takes them."""
        first = self.grid.origin + 0.5 * (2**self.level - 1) * self.grid.spacing
        return _core.Blocks(self.shape, self.spacing, first.tolist(), self.reach)

    def around(self, cells: CellArray) -> Numbers:
        """Numbers of the blocks that hold cells of the grid, (n, d)."""
        return numbers_of(cells >> self.level, self.shape)


def numbers_of(cells: CellArray, shape: tuple[int, ...]) -> Numbers:
    """Numbers (n,), in C order, of cells (n, d)."""
    return np.asarray(np.ravel_multi_index(tuple(cells.T), shape), dtype=np.int64)
