"""The quickest path through a map, marched only where it can lie.

The map is looked at in blocks of cells, from coarse to fine. In each block the wave runs as fast as
in the fastest of its cells, so that it is never later there than in the map itself: what it says
of the way from start to goal through a block is a lower bound. Only blocks whose bound does not
exceed a limit are looked at more closely, at last cell by cell. Where the path that is found takes
longer than the limit, this rises to what was found, and the search begins again: in the end no path
outside the band can be quicker. The cost thus grows with the path, not with the map.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress, pairwise

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.planning.blocks import Blocks, Numbers, numbers_of
from leadthrough.planning.grid import CellArray
from leadthrough.planning.speed_field import SpeedField

# Maps of fewer blocks are marched as a whole.
_MOST_BLOCKS = 2_000
# A limit exceeds what blocks let hope for by this fraction, times two for every level: the smaller
# they are, the more there is in the way.
_HOPE = 0.0175
# By how much the scheme's error may let a wave seem later than it is.
_ERROR = 0.01
# A limit at which obstacles separate the ends in the band grows by this factor.
_GROWTH = 1.5
# Cells about the goal with exact times, as in `arrival_times`.
_BALL = 8.0
# Blocks kept about those that the quickest path may pass, in their edges: the scheme's gradients
# at the band's border are those of a wall.
_ROOM = 1.5
_STEP = 0.5  # of the descent, in cells


def quickest(field: SpeedField, start: Float64Array, goal: Float64Array) -> Float64Array:
    """The path (n, d) of least time, the same as in a march through the whole map.

    One of the ends may lie outside the grid: the path is straight between it and the first cell.

    Args:
        field: speeds in cells.
        start: (d,).
        goal: (d,).

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    ends = np.stack([start, goal])
    inside = field.grid.contains(ends)
    for name, point in compress(zip(("start", "goal"), ends, strict=True), inside):
        if field.at(numbers_of(field.grid.cells_of(point[None]), field.grid.shape))[0] == 0.0:
            raise NoPath(f"{name}: {point} lies in an obstacle", reason=f"{name}_in_wall")
    if not inside[1]:
        return quickest(field, goal, start)[::-1]
    with check.enough_memory(f"resolution: a grid of shape {field.grid.shape}"):
        return _Search(field, start, goal).path()


@dataclass(frozen=True, eq=False)
class _End:
    """Where a wave enters blocks: one block, or those at the border that face a place outside.

    Attributes:
        numbers: of the blocks.
        times: when the wave is there, or somewhere in the block, at the earliest.
        is_outside: whether the place lies outside the grid.
    """

    numbers: Numbers
    times: Float64Array
    is_outside: bool

    def wave(
        self, cells: _core.CellSet, speed: Float64Array, *, ball: float = 0.0, stop: int = -1
    ) -> Float64Array:
        """Times (n,) of arrival in cells, up to a cell to stop at."""
        return cells.march(speed, self.numbers, self.times, ball, stop)

    def reached(self, cells: _core.CellSet, times: Float64Array) -> Float64Array:
        """Times (k,) at which a wave from elsewhere gets here by each of the blocks."""
        places = cells.find(self.numbers)
        return np.where(places < 0, np.inf, times[places] + self.times)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What waves through blocks tell.

    Attributes:
        numbers: of the blocks.
        through: (n,) least times of ways from start to goal through each.
        arrival: the least of all; inf if there is no way.
        is_open: whether there may be one beyond these blocks.
    """

    numbers: Numbers
    through: Float64Array
    arrival: float
    is_open: bool


class _Search:
    """The search for the band that holds the quickest path to a goal in the grid."""

    def __init__(self, field: SpeedField, start: Float64Array, goal: Float64Array) -> None:
        self._field, self._start, self._goal = field, start, goal
        inside = field.grid.contains(np.stack([start, goal]))
        self._cells = [
            field.grid.cells_of(place[None]) if held else None
            for place, held in zip((start, goal), inside, strict=True)
        ]
        top = 0
        while Blocks(field.grid, top).count > _MOST_BLOCKS:
            top += 1
        self._levels = [Blocks(field.grid, level) for level in range(top, -1, -1)]
        self._least = 0.0  # of all limits
        self._limit = np.inf  # the lowest one above which blocks were left out
        self._is_whole = True  # whether the band holds every cell
        self._seen: dict[int, _Seen] = {}  # at last, at each level
        self._asked: tuple[_core.CellSet, Float64Array] | None = None  # cells and speeds, at last

    def path(self) -> Float64Array:
        """The quickest path (n, d).

        Raises:
            NoPath: where obstacles separate the ends.
        """
        marched, path, is_found = np.zeros(0, dtype=np.int64), None, False
        while path is None or not is_found:
            band = self._band()
            if band is None:
                continue
            # With a higher limit the band may still be the same one.
            is_found = path is not None and np.array_equal(band, marched)
            if not is_found:
                marched = band
                path, is_found = self._path_in(band)
        return path

    def _path_in(self, band: Numbers) -> tuple[Float64Array | None, bool]:
        """The quickest path among given cells, and whether the limit was high enough for it."""
        finest, grid = self._levels[-1], self._field.grid
        start, goal = self._ends(finest, band)
        radius = _BALL * min(finest.spacing)
        band = _united(band, _core.cells_within(finest.shape, finest.spacing, goal.numbers, radius))
        cells = _core.CellSet(finest.shape, finest.spacing, band)
        stop = -1 if start.is_outside else int(start.numbers[0])
        times = goal.wave(cells, self._speeds(cells, band), ball=_BALL, stop=stop)
        reached = start.reached(cells, times)
        arrival = float(reached.min(initial=np.inf))
        is_found = self._holds(arrival, _ERROR, cells.is_open(times))
        if np.isinf(arrival):
            return None, False
        ends = np.stack([self._start, self._goal])
        if start.is_outside:
            ends[0] = finest.centres(start.numbers[[np.argmin(reached)]])[0]
        first, last = grid.coordinates(ends).tolist()
        status, coordinates = cells.descend(times, first, last, _STEP)
        assert status == "ok", status  # every cell that was reached leads down to the source
        path = grid.points_at(coordinates)
        path[[0, -1]] = ends
        return (np.concatenate([self._start[None], path]) if start.is_outside else path), is_found

    def _speeds(self, cells: _core.CellSet, numbers: Numbers) -> Float64Array:
        """Speeds (n,) of cells; the map is not asked again for those it was asked for at last."""
        if self._asked is None:
            speeds = self._field.at(numbers)
        else:
            places = self._asked[0].find(numbers)
            new = places < 0
            speeds = self._asked[1][places]
            speeds[new] = self._field.at(numbers[new])
        self._asked = cells, speeds
        return speeds

    def _band(self) -> Numbers | None:
        """The cells that the quickest path may pass; None where a limit was too low."""
        self._is_whole, self._limit = True, np.inf
        numbers = np.arange(self._levels[0].count)
        for blocks, finer in pairwise(self._levels):
            seen = self._look(blocks, numbers)
            hope = _HOPE * 2**blocks.level
            if not self._holds(seen.arrival, hope, seen.is_open):
                return None
            self._limit = min(self._limit, max(self._least, seen.arrival * (1.0 + hope)))
            kept = seen.numbers[seen.through <= self._limit]
            if finer.level == 0:
                room = _ROOM * max(blocks.spacing)
                kept = _core.cells_within(blocks.shape, blocks.spacing, kept, room)
            self._is_whole = self._is_whole and len(kept) == blocks.count
            numbers = _core.finer_cells(blocks.shape, finer.shape, kept)
        return numbers

    def _look(self, blocks: Blocks, numbers: Numbers) -> _Seen:
        """What waves from both ends through given blocks tell."""
        seen = self._seen.get(blocks.level)
        # With a higher limit the blocks may still be the same ones.
        if seen is None or not np.array_equal(seen.numbers, numbers):
            seen = self._seen[blocks.level] = self._look_anew(blocks, numbers)
        return seen

    def _look_anew(self, blocks: Blocks, numbers: Numbers) -> _Seen:
        cells = _core.CellSet(blocks.shape, blocks.spacing, numbers)
        ends = self._ends(blocks, numbers)
        through, arrival, is_open = cells.waves(
            self._field.fastest(blocks, numbers),
            [end.numbers for end in ends],
            [end.times for end in ends],
            [end.is_outside for end in ends],
            blocks.reach,
        )
        return _Seen(numbers, through, arrival, is_open)

    def _ends(self, blocks: Blocks, numbers: Numbers) -> tuple[_End, _End]:
        """Where waves from start and goal enter given blocks."""
        start, goal = self._cells
        return (
            self._end(blocks, numbers, self._start, start),
            self._end(blocks, numbers, self._goal, goal),
        )

    def _end(
        self, blocks: Blocks, numbers: Numbers, place: Float64Array, cell: CellArray | None
    ) -> _End:
        if cell is not None:
            return _End(blocks.around(cell), np.zeros(1), is_outside=False)
        grid = self._field.grid
        last = grid.origin + grid.spacing * (np.array(grid.shape) - 1)
        at = np.stack(np.unravel_index(numbers, blocks.shape), axis=-1)
        before, after = place < grid.origin, place > last
        facing = ((at == 0) & before) | ((at == np.array(blocks.shape) - 1) & after)
        border = numbers[facing.any(axis=1)]
        away = np.linalg.norm(blocks.centres(border) - place, axis=1) - blocks.reach
        # Counted from where the wave first meets the grid: the way there is all the same.
        nearest = float(np.linalg.norm(np.clip(place, grid.origin, last) - place))
        return _End(border, np.maximum(away - nearest, 0.0) / self._field.outside, is_outside=True)

    def _holds(self, arrival: float, hope: float, is_open: bool) -> bool:
        """Whether no quicker path leaves the band; if one may, the next limits are higher.

        Raises:
            NoPath: where obstacles separate the ends.
        """
        if np.isinf(arrival):
            if self._is_whole or not is_open:
                raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
            self._least = _GROWTH * self._limit
            return False
        if self._is_whole or arrival * (1.0 + _ERROR) <= self._limit:
            return True
        self._least = arrival * (1.0 + hope)
        return False


def _united(cells: Numbers, more: Numbers) -> Numbers:
    """Ascending cells with some more."""
    places = np.minimum(np.searchsorted(cells, more), len(cells) - 1)
    return np.sort(np.concatenate([cells, more[cells[places] != more]]), kind="stable")
