"""Speeds of a map's cells, computed where they are asked for, however large the map is.

The maps of `speed_map`, cell by cell, and upper bounds of them over blocks of cells.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1 and eq. 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.brief import Brief
from leadthrough.check import Float64Array
from leadthrough.planning.blocks import Blocks, Numbers, numbers_of
from leadthrough.planning.grid import CellArray, Grid
from leadthrough.planning.speed_map import IN_TUBE, ROUNDING, fine_samples
from leadthrough.planning.walls import Walls

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


class SpeedField(Protocol):
    """Speeds of the cells of a grid."""

    @property
    def grid(self) -> Grid:
        """Of the cells."""
        ...

    @property
    def outside(self) -> float:
        """Speed beyond the grid, where there are no walls; 0 where no wave goes there."""
        ...

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells, which are ascending; 0 in walls."""
        ...

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """Upper bounds (n,) of the speeds of the cells of blocks; 0 where all are walls."""
        ...


class FreeField(SpeedField, Protocol):
    """Speeds without obstacles, above a saturation in tubes around paths only."""

    @property
    def in_tube(self) -> Numbers:
        """Ascending numbers of the cells in tubes."""
        ...


def speeds_at(field: SpeedField, cells: CellArray) -> Float64Array:
    """Speeds (n,) of cells (n, d) in any order."""
    asked, of = np.unique(numbers_of(cells, field.grid.shape), return_inverse=True)
    return field.at(asked)[of]


def _crossed(grid: Grid, paths: Sequence[Float64Array]) -> Numbers:
    """Ascending numbers of the cells that the points (n, d) of paths lie in."""
    cells = [grid.cells_of(path) for path in paths]
    return np.unique(
        numbers_of(np.concatenate(cells or [np.zeros((0, grid.dimensions), int)]), grid.shape)
    )


@dataclass(frozen=True, eq=False)
class MapField(Brief):
    """The speeds of a map that is there already.

    Attributes:
        grid: of the map.
        speed: of grid.shape.
        outside: speed beyond the grid.
    """

    grid: Grid
    speed: NDArray[Any]
    outside: float = 0.0

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells."""
        return np.asarray(self.speed.ravel()[cells], dtype=np.float64)

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """The largest speeds (n,) of the cells of blocks."""
        if blocks.level == 0:
            return self.at(numbers)
        size = 2**blocks.level
        speed: NDArray[Any] = self.speed
        for axis, count in enumerate(self.grid.shape):
            speed = np.maximum.reduceat(speed, np.arange(0, count, size), axis=axis)
        return np.asarray(speed.ravel()[numbers], dtype=np.float64)


class ExperienceField:
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
        self.grid = grid
        self.outside = self._saturation = saturation
        crossed = _crossed(grid, [fine_samples(path, grid) for path in paths])
        shape, spacing = grid.shape, grid.spacing.tolist()
        reach = area_of_influence * (1.0 + ROUNDING)
        self.in_tube = _core.cells_within(shape, spacing, crossed, reach)
        self._set = _core.CellSet(shape, spacing, self.in_tube)
        depth = self._set.depths()
        deepest = float(depth.max(initial=0.0))
        # Experience everywhere has no border.
        fractions = np.ones(len(depth)) if np.isinf(deepest) else depth / deepest
        self._speeds = saturation + (1.0 - saturation) * fractions
        self._pooled: dict[int, tuple[Numbers, Float64Array]] = {}

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells."""
        places = self._set.find(cells)
        speeds = np.full(len(cells), self._saturation)
        speeds[places >= 0] = self._speeds[places[places >= 0]]
        return speeds

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """The largest speeds (n,) of the cells of blocks."""
        if blocks.level not in self._pooled:
            self._pooled[blocks.level] = self._pool(blocks)
        held, speeds = self._pooled[blocks.level]
        if len(held) == 0:
            return np.full(len(numbers), self._saturation)
        places = np.minimum(np.searchsorted(held, numbers), len(held) - 1)
        return np.where(held[places] == numbers, speeds[places], self._saturation)

    def _pool(self, blocks: Blocks) -> tuple[Numbers, Float64Array]:
        """Blocks that hold cells in tubes, ascending, and the largest speed in each."""
        cells = np.stack(np.unravel_index(self.in_tube, self.grid.shape), axis=-1)
        held, of = np.unique(blocks.around(cells), return_inverse=True)
        speeds = np.zeros(len(held))
        np.maximum.at(speeds, of, self._speeds)
        return held, speeds


class TubeField:
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
        self.grid = grid
        self._cells = Blocks(grid, 0)
        self._paths = [np.ascontiguousarray(fine_samples(path, grid)) for path in paths]
        self._weights = [float(weight) for weight in weights]
        self._radius = area_of_influence
        self.outside = self._saturation = saturation

    @cached_property
    def in_tube(self) -> Numbers:
        """Ascending numbers of the cells in tubes."""
        grid = self.grid
        reach = self._radius + 0.5 * float(np.linalg.norm(grid.spacing))
        crossed = _crossed(grid, self._paths)
        near = _core.cells_within(grid.shape, grid.spacing.tolist(), crossed, reach)
        return near[self.at(near) > self._saturation]

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells."""
        return self._speeds(self._cells, cells)

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """Upper bounds (n,) of the speeds of the cells of blocks."""
        return self._speeds(blocks, numbers)

    def _speeds(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        return _core.tube_speeds(
            blocks.compiled, numbers, self._paths, self._weights, self._radius, self._saturation
        )


class HinderedField:
    """The speeds of `add_obstacles`: a field without obstacles times how far these are.

    Args:
        free: the field without obstacles.
        walls: of its grid.
        area_of_influence: in the grid's unit.
    """

    def __init__(self, free: SpeedField, walls: Walls, *, area_of_influence: float) -> None:
        self.grid, self.outside = free.grid, free.outside
        self._free, self._walls, self._reach = free, walls, area_of_influence

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells."""
        beside = self._walls.distances(cells, self._reach) / self._reach
        return np.asarray(self._free.at(cells) * beside)

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """Upper bounds (n,) of the speeds of the cells of blocks."""
        beside = self._walls.farthest(blocks, numbers, self._reach) / self._reach
        return np.asarray(self._free.fastest(blocks, numbers) * beside)


class SaturatedField:
    """The speeds of `add_saturated_obstacles`, eq. 7 of the paper.

    Args:
        free: the field without obstacles.
        walls: of its grid.
        area_of_influence: in the grid's unit.
        saturation: in (0, 1].
    """

    def __init__(
        self, free: SpeedField, walls: Walls, *, area_of_influence: float, saturation: float
    ) -> None:
        self.grid, self.outside = free.grid, free.outside
        self._free, self._walls = free, walls
        self._reach, self._saturation = area_of_influence, saturation

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells."""
        beside = self._walls.distances(cells, self._reach) / self._reach
        return self._lower(self._free.at(cells), beside)

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """Upper bounds (n,) of the speeds of the cells of blocks."""
        beside = self._walls.farthest(blocks, numbers, self._reach) / self._reach
        return self._lower(self._free.fastest(blocks, numbers), beside)

    def _lower(self, free: Float64Array, beside: Float64Array) -> Float64Array:
        return np.where(beside < self._saturation, np.minimum(free, beside), free)


class PassableField:
    """The speeds of `add_passable_obstacles`, with ways round obstacles that stand in tubes.

    Args:
        free: the field without obstacles.
        walls: of its grid.
        band: distance over which the speed grows from 0 at an obstacle to its own value.
        saturation: speed outside the tubes, in (0, 1].
        reach: of the ways round, from where an obstacle stands in a tube.
    """

    def __init__(
        self, free: FreeField, walls: Walls, *, band: float, saturation: float, reach: float
    ) -> None:
        self.grid, self.outside = free.grid, free.outside
        self._free, self._walls = free, walls
        self._around, self._saturation, self._reach = 2.0 * band, saturation, reach

    def at(self, cells: Numbers) -> Float64Array:
        """Speeds (n,) of cells."""
        beside = self._walls.distances(cells, self._around) / self._around
        free = self._free.at(cells)
        near = (beside > 0.0) & (beside < 1.0)
        near[near] = self._near_struck(Blocks(self.grid, 0).centres(cells[near]), 0.0)
        closeness = np.where(near, 1.0 - np.abs(2.0 * beside - 1.0), 0.0)
        way = np.maximum(free, self._saturation + (1.0 - self._saturation) * closeness)
        return np.asarray(way * np.minimum(2.0 * beside, 1.0))

    def fastest(self, blocks: Blocks, numbers: Numbers) -> Float64Array:
        """Upper bounds (n,) of the speeds of the cells of blocks."""
        beside = self._walls.farthest(blocks, numbers, self._around) / self._around
        speed = self._free.fastest(blocks, numbers)
        near = self._walls.nearest(blocks, numbers, self._around) < self._around
        near[near] = self._near_struck(blocks.centres(numbers[near]), blocks.reach)
        speed[near] = 1.0
        return np.asarray(speed * np.minimum(2.0 * beside, 1.0))

    def _near_struck(self, points: Float64Array, room: float) -> NDArray[np.bool_]:
        """Whether points (n, d) lie within the reach, and room, of walls in a tube."""
        if self._struck is None or len(points) == 0:
            return np.zeros(len(points), dtype=bool)
        bound = (self._reach + room) * (1.0 + ROUNDING)
        return np.asarray(np.isfinite(self._struck.query(points, distance_upper_bound=bound)[0]))

    @cached_property
    def _struck(self) -> cKDTree | None:
        """The walls that stand in tubes."""
        from scipy.spatial import cKDTree

        tube = self._free.in_tube
        tube = tube[self._free.at(tube) > self._saturation * (1.0 + IN_TUBE)]
        struck = tube[self._walls.hold(tube)]
        return cKDTree(Blocks(self.grid, 0).centres(struck)) if len(struck) else None
