"""Arrival times of a front: the eikonal equation |grad T| = 1 / speed, by fast marching.

Source: Sethian 1996, "A fast marching level set method for monotonically advancing fronts"; second
order: Sethian 1999, "Fast marching methods".
"""

from __future__ import annotations

import copy
import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.planning.grid import MAX_CELLS, Grid, bounds_of, check_grid, spacings

FloatArray = NDArray[np.float32] | NDArray[np.float64]
# Any: numbers of every type may come in, and which precision they get is known only then.
Numbers = NDArray[Any]
Precision = np.dtype[Any]
Kind = Literal["none", "repair", "full_march"]
if TYPE_CHECKING:
    from typing_extensions import TypeVar as _TypeVar  # takes defaults

    FloatT = _TypeVar("FloatT", np.float32, np.float64, default=np.float64)
else:
    FloatT = TypeVar("FloatT", np.float32, np.float64)

# Cells; at second order it takes the largest error of a point source in 150^3 cells of constant
# speed from 0.62 to 0.08 cells. At first order the error grows from everywhere, not the source.
_SOURCE_RADIUS = {1: 0.0, 2: 8.0}
_MAX_RADIUS = 50.0
# Beyond this ratio squares of times leave the range of float32.
_MAX_SPEED_RATIO = 1e15

# An ArrivalField counts in units of up to this times its fastest speed.
_HEADROOM = 4.0


def arrival_times(
    speed: ArrayLike,
    sources: ArrayLike,
    *,
    spacing: ArrayLike = 1.0,
    order: int = 1,
    dtype: type[FloatT] = np.float64,  # type: ignore[assignment]  # the default of FloatT
    stop: ArrayLike | None = None,
    source_radius: float | None = None,
) -> NDArray[FloatT]:
    """Arrival times of a front that leaves the sources at time 0; inf in unreachable cells.

    Args:
        speed: 2-D or 3-D map of speeds, length per time, >= 0; 0 is a wall, and the slowest other
            speed must be above 1e-15 times the fastest.
        sources: indices of cells, (d,) or (k, d).
        spacing: distance between neighbouring cells, > 0, (d,) or one number.
        order: of the scheme, 1 or 2.
        dtype: float32 or float64, of times and arithmetic.
        stop: index of a cell (d,); cells that the front reaches later stay inf, which saves time.
        source_radius: in cells (of the smallest spacing), 0 to 50; within it times are exact
            distances over the source's speed, as far as no cell of another speed comes near and at
            most half way to the next source. By default 0 at order 1 and 8 at order 2.

    Returns:
        Times of the map's shape.

    Raises:
        InvalidInput: if a source lies in a wall, or the speeds' range is too wide for the dtype.
    """
    precision = precision_of(dtype)
    check.integer(order, "order", at_least=1, at_most=2)
    radius = _radius(source_radius, order)
    field = checked_speeds(speed)
    cells = source_cells(sources, field)
    last = -1 if stop is None else int(flat_indices(stop, "stop", field.shape)[0])
    steps = spacings(spacing, field.ndim)
    check_range(*range_of(field), cells=field.size, spacing=steps, dtype=precision)
    with check.enough_memory(f"speed: a grid of shape {field.shape}"):
        map_ = np.ascontiguousarray(field, precision)
        times: NDArray[FloatT] = core.march(map_, steps.tolist(), cells, order, radius, last)
        return times


def arrival_times_batch(
    speeds: Sequence[ArrayLike],
    sources: Sequence[ArrayLike],
    *,
    spacing: ArrayLike = 1.0,
    order: int = 1,
    dtype: type[np.float32] | type[np.float64] = np.float64,
    source_radius: float | None = None,
    threads: int = 1,
) -> list[NDArray[Any]]:  # Any: of the dtype, which only arrays know
    """The times of several problems, as `arrival_times` computes them one by one.

    Args:
        speeds: maps of one shape; a single map serves all sources.
        sources: one entry per problem; a single entry serves all maps.
        threads: at least 1; the bits of the result do not depend on it.

    Returns:
        Times of the maps' shape, one array per problem.
    """
    precision = precision_of(dtype)
    check.integer(order, "order", at_least=1, at_most=2)
    check.integer(threads, "threads", at_least=1)
    radius = _radius(source_radius, order)
    maps = [checked_speeds(speed) for speed in _entries(speeds, "speeds")]
    starts = _entries(sources, "sources")
    count = _count(len(maps), len(starts))
    if len(shapes := {field.shape for field in maps}) > 1:
        raise InvalidInput(f"speeds: expected maps of one shape, got {sorted(shapes)}")
    steps = spacings(spacing, maps[0].ndim)
    for field in maps:
        check_range(*range_of(field), cells=field.size, spacing=steps, dtype=precision)
    fields = [k % len(maps) for k in range(count)]
    cells = [source_cells(starts[k % len(starts)], maps[fields[k]]) for k in range(count)]
    with check.enough_memory(f"speeds: {count} grids of shape {maps[0].shape}"):
        arrays = [np.ascontiguousarray(field, precision) for field in maps]
        some = [arrays[k] for k in fields]
        return core.march_batch(some, steps.tolist(), cells, order, radius, threads)


def nearest_sources(
    arrival: ArrayLike, sources: ArrayLike, *, spacing: ArrayLike = 1.0
) -> NDArray[np.int32]:
    """Index of the source whose front reached each cell; -1 in unreachable cells.

    The index is carried down the characteristics: each cell takes a mean of its earlier
    neighbours' fractions of the sources, by the weights of the differentiated upwind equation.
    The border between two fronts is right to about a cell.

    Args:
        arrival: 2-D or 3-D times >= 0, from `arrival_times` with the same sources and spacing.
        sources: indices of cells (k, d); of sources in one cell the first counts.
        spacing: distance between neighbouring cells, > 0, (d,) or one number.

    Returns:
        Indices of the shape of `arrival`.
    """
    raw = check.regular(arrival, "arrival")
    if raw.dtype.kind != "f" or raw.ndim not in (2, 3) or raw.size == 0 or not raw.min() >= 0.0:
        raise check.refused(
            "arrival", "a 2-D or 3-D array of times >= 0", f"shape {raw.shape} of {raw.dtype}"
        )
    cells = flat_indices(sources, "sources", raw.shape)
    times = np.ascontiguousarray(raw, np.float64)
    return core.nearest_sources(times, spacings(spacing, raw.ndim).tolist(), cells.tolist())


@dataclass(frozen=True)
class FieldUpdate(ShortRepr):
    """The effect of an update.

    Attributes:
        kind: "none" if no speed changed, "repair" or "full_march".
        invalidated: number of cells whose times depended on speeds that fell; with a full march,
            of those visited until it proved cheaper.
    """

    kind: Kind
    invalidated: int


class ArrivalField:
    """First-order arrival times from sources, updated with a changing speed map.

    First order, because only there each time is a function of its neighbours' times alone: at
    second order it also depends on the sequence of the march.

    `update` and `update_part` change the object in place, at a cost in proportion to what changes;
    arrays that it has returned stay as they are. Several threads may use it; they take turns.

    Args:
        speed: of grid.shape, as for `arrival_times`.
        grid: of the map.
        sources: points (d,) or (k, d) in cells of speed > 0.
        dtype: float32 or float64, of times and arithmetic.

    Raises:
        InvalidInput: if a source lies outside the grid or in a wall.
    """

    def __init__(
        self, speed: ArrayLike, grid: Grid, sources: ArrayLike, *, dtype: DTypeLike = np.float64
    ) -> None:
        self._precision = precision_of(dtype)
        field = checked_speeds(speed)
        if field.shape != check_grid(grid).shape:
            raise check.refused("speed", f"the grid's shape {grid.shape}", f"shape {field.shape}")
        points = check.regular(sources, "sources")
        cells = grid.cells_of(points[None] if points.ndim == 1 else points)
        self._sources = source_cells(cells, field)
        self._grid = grid
        self._fastest = 0.0
        self._check_range(field)
        with check.enough_memory(f"speed: a grid of shape {field.shape}"):
            self._speed = np.array(field, self._precision, order="C")
            self._march()

    def _march(self) -> None:
        """Arrival times from the sources."""
        single = self._precision == np.float32
        make = core.ArrivalFieldFloat32 if single else core.ArrivalFieldFloat64
        self._field: core.ArrivalFieldFloat32 | core.ArrivalFieldFloat64
        self._field = make(self._speed, self._grid.spacing.tolist(), self._sources)
        self._times: FloatArray | None = None
        self._lock = threading.RLock()

    def __getstate__(self) -> dict[str, Any]:  # the times are computed again
        parts = ("_precision", "_sources", "_grid", "_fastest", "_speed")
        with self._lock:
            return copy.deepcopy({name: getattr(self, name) for name in parts})

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._march()

    @property
    def grid(self) -> Grid:
        """The grid it was made with."""
        return self._grid

    @property
    def speed(self) -> FloatArray:
        """A copy of the speed map as it is now, of grid.shape."""
        with self._lock:
            return self._speed.copy()

    @property
    def times(self) -> FloatArray:
        """Current arrival times of grid.shape, read-only; inf in unreachable cells.

        After each update this is a new array, which takes 4 ms for 150^3 cells of float32.
        """
        with self._lock:
            if self._times is None:
                self._times = check.freeze(self._field.times())
            return self._times

    def update(self, speed: ArrayLike) -> FieldUpdate:
        """Replaces the whole speed map; the changed part is determined first.

        Raises:
            InvalidInput: if the map puts a source in a wall; nothing is changed then.
        """
        field = check.regular(speed, "speed")
        if field.shape != self._grid.shape or field.dtype.kind not in "fiu":
            raise InvalidInput(
                f"speed: expected numbers of shape {self._grid.shape}, "
                f"got shape {field.shape} of {field.dtype}"
            )
        with self._lock, np.errstate(over="ignore"):
            part = bounds_of(np.asarray(field, self._precision) != self._speed)
            return FieldUpdate("none", 0) if part is None else self.update_part(part, field[part])

    def update_part(self, part: tuple[slice, ...], speed: ArrayLike) -> FieldUpdate:
        """Replaces the speeds of a box of cells, without looking at the others.

        Args:
            part: slices of the map (d,), without steps.
            speed: of the part's shape, or one number.

        Raises:
            InvalidInput: if the part puts a source in a wall; nothing is changed then.
        """
        low, shape = self._box(part)
        values = finite_speeds(np.broadcast_to(_fitting(speed, shape), shape))
        with self._lock:
            self._check_sources(low, values)
            self._check_range(values)
            new = np.ascontiguousarray(values, self._precision)
            self._speed[tuple(slice(a, a + n) for a, n in zip(low, shape, strict=True))] = new
            self._times = None
            kind, invalidated = self._field.update(low, new)
            return FieldUpdate(cast(Kind, kind), invalidated)

    def _box(self, part: tuple[slice, ...]) -> tuple[list[int], tuple[int, ...]]:
        d = self._grid.dimensions
        if not isinstance(part, tuple) or len(part) != d:
            raise InvalidInput(f"part: expected a tuple of {d} slices, got {part!r}")
        low, shape = [], []
        for piece, count in zip(part, self._grid.shape, strict=True):
            if not isinstance(piece, slice) or piece.step not in (None, 1):
                raise InvalidInput(f"part: expected slices without steps, got {piece!r}")
            try:
                start, stop, _ = piece.indices(count)
            except TypeError:
                raise InvalidInput(f"part: expected slices of integers, got {piece!r}") from None
            if stop <= start:
                raise InvalidInput(f"part: expected at least one cell, got {piece!r} of {count}")
            low.append(start)
            shape.append(stop - start)
        return low, tuple(shape)

    def _check_range(self, new: Numbers) -> None:
        """Checks and remembers the fastest speed so far: the field counts in units of it."""
        slowest, fastest = range_of(new)
        if 0.0 < self._fastest < fastest:
            slowest = min(slowest, range_of(self._speed)[0])
        highest = max(fastest, self._fastest)
        check_range(
            slowest,
            highest,
            cells=math.prod(self._grid.shape),
            spacing=self._grid.spacing,
            dtype=self._precision,
        )
        self._fastest = highest

    def _check_sources(self, low: list[int], new: Numbers) -> None:
        cells = np.stack(np.unravel_index(self._sources, self._grid.shape), axis=-1) - low
        inside = cells[((cells >= 0) & (cells < new.shape)).all(axis=1)]
        walled = inside[new[tuple(inside.T)] == 0.0]
        if len(walled):
            point = self._grid.origin + self._grid.spacing * (walled[0] + low)
            raise InvalidInput(f"speed: expected speed > 0 at the sources, got a wall at {point}")


# Any: maps and sources pass through here alike; each is checked where it is used.
def _entries(values: Sequence[Any], name: str) -> list[Any]:
    entries = list(values) if np.iterable(values) and not isinstance(values, str) else []
    if not entries:
        raise InvalidInput(f"{name}: expected a sequence, one entry per problem, got {values!r}")
    return entries


def _count(maps: int, sources: int) -> int:
    count = max(maps, sources)
    if {maps, sources} - {1, count}:
        raise InvalidInput(
            "sources: expected as many entries as speeds, or a single one of either, "
            f"got {sources} for {maps}"
        )
    return count


def _radius(source_radius: float | None, order: int) -> float:
    if source_radius is None:
        return _SOURCE_RADIUS[order]
    return check.number(source_radius, "source_radius", at_least=0.0, at_most=_MAX_RADIUS)


def precision_of(dtype: DTypeLike) -> Precision:
    """The type in which a march computes, float32 or float64; raises InvalidInput for others."""
    try:
        precision = np.dtype(dtype)
    except TypeError:
        raise InvalidInput(f"dtype: expected float32 or float64, got {dtype!r}") from None
    if precision not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise InvalidInput(f"dtype: expected float32 or float64, got {precision}")
    return precision


def checked_speeds(speed: ArrayLike) -> Numbers:
    """`speed` as a 2-D or 3-D array of finite numbers >= 0; raises InvalidInput for others."""
    field = check.regular(speed, "speed")
    if field.dtype.kind not in "fiu" or field.ndim not in (2, 3) or field.size == 0:
        raise check.refused(
            "speed", "a 2-D or 3-D array of numbers", f"shape {field.shape} of {field.dtype}"
        )
    if field.size > MAX_CELLS:
        raise InvalidInput(f"speed: expected at most {MAX_CELLS:.0e} cells, got {field.size}")
    return finite_speeds(field)


def finite_speeds(field: Numbers) -> Numbers:
    if not (field.min() >= 0 and field.max() < np.inf):
        at = tuple(int(i) for i in np.argwhere(~((field >= 0) & (field < np.inf)))[0])
        raise InvalidInput(f"speed: expected finite numbers >= 0, got {field[at]} at {at}")
    return field


def range_of(speed: Numbers) -> tuple[float, float]:
    """The slowest speed above 0, inf if there is none, and the fastest."""
    least = float(speed.min())
    slowest = least if least > 0.0 else float(np.where(speed > 0, speed, np.inf).min())
    return slowest, float(speed.max())


def check_range(
    slowest: float, fastest: float, *, cells: int, spacing: Float64Array, dtype: Precision
) -> None:
    """Checks that times can be distinguished and stay in the range of a precision."""
    if slowest < fastest / _MAX_SPEED_RATIO:
        raise InvalidInput(
            f"speed: expected 0 or at least {1 / _MAX_SPEED_RATIO:.0e} times the fastest, "
            f"{fastest}, got {slowest}; make such cells walls (0) or faster"
        )
    limits = np.finfo(dtype)
    with np.errstate(over="ignore"):
        quickest = spacing.min() / np.float64(fastest)
        longest = spacing.max() / np.float64(slowest) * cells
        highest = _HEADROOM * np.float64(fastest)
    if not (limits.tiny < min(quickest, slowest) and max(longest, highest) < limits.max):
        raise InvalidInput(
            f"speed: expected times in the range of {dtype}, got speeds from {slowest} to {fastest}"
        )


def source_cells(sources: ArrayLike, speed: Numbers) -> NDArray[np.int64]:
    """Flat indices (k,) of sources in free cells; raises InvalidInput for one in a wall."""
    cells = flat_indices(sources, "sources", speed.shape)
    walls = speed.ravel()[cells] == 0.0
    if walls.any():
        at = np.unravel_index(cells[int(np.argmax(walls))], speed.shape)
        raise InvalidInput(
            f"sources: expected cells of speed > 0, got a wall at {tuple(int(i) for i in at)}"
        )
    return cells


def flat_indices(indices: ArrayLike, name: str, shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Flat indices (k,) of cells given as (d,) or (k, d), k > 0; raises InvalidInput for others."""
    cells = check.regular(indices, name)
    dimensions = len(shape)
    if cells.dtype.kind not in "iu" or cells.ndim not in (1, 2) or cells.shape[-1] != dimensions:
        raise InvalidInput(
            f"{name}: expected integer indices of shape ({dimensions},) or (k, {dimensions}), "
            f"got shape {cells.shape} of {cells.dtype}"
        )
    rows = cells.reshape(-1, dimensions)
    if len(rows) == 0:
        raise InvalidInput(f"{name}: expected at least one cell, got none")
    outside = ((rows < 0) | (rows >= np.array(shape))).any(axis=1)
    if outside.any():
        row = tuple(int(i) for i in rows[int(np.argmax(outside))])
        raise InvalidInput(f"{name}: expected cells in a grid of shape {shape}, got {row}")
    return np.asarray(np.ravel_multi_index(tuple(rows.T), shape), dtype=np.int64)


def _fitting(speed: ArrayLike, shape: tuple[int, ...]) -> Numbers:
    values = check.regular(speed, "speed")
    if values.dtype.kind not in "fiu" or values.shape not in ((), shape):
        raise InvalidInput(
            f"speed: expected a number or numbers of the part's shape {shape}, "
            f"got shape {values.shape} of {values.dtype}"
        )
    return values
