"""Arrival times of a front: the eikonal equation |grad T| = 1 / speed, by fast marching.

Source: Sethian 1996, "A fast marching level set method for monotonically advancing fronts"; second
order: Sethian 1999, "Fast marching methods".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import spacings
from leadthrough.planning.march_input import (
    FloatArray,
    check_range,
    flat_indices,
    precision_of,
    range_of,
    source_cells,
    speed_map,
)

# Cells; at second order it takes the largest error of a point source in 150^3 cells of constant
# speed from 0.62 to 0.08 cells. At first order the error grows from everywhere, not the source.
_SOURCE_RADIUS = {1: 0.0, 2: 8.0}
_LARGEST_RADIUS = 50.0


@overload  # no type is both float32 and float64
def arrival_times(  # type: ignore[overload-overlap]
    speed: ArrayLike,
    sources: ArrayLike,
    *,
    spacing: ArrayLike = ...,
    order: int = ...,
    dtype: type[np.float32],
    stop: ArrayLike | None = ...,
    source_radius: float | None = ...,
) -> NDArray[np.float32]: ...
@overload
def arrival_times(
    speed: ArrayLike,
    sources: ArrayLike,
    *,
    spacing: ArrayLike = ...,
    order: int = ...,
    dtype: type[np.float64] = ...,
    stop: ArrayLike | None = ...,
    source_radius: float | None = ...,
) -> Float64Array: ...
@overload
def arrival_times(
    speed: ArrayLike,
    sources: ArrayLike,
    *,
    spacing: ArrayLike = ...,
    order: int = ...,
    dtype: DTypeLike,
    stop: ArrayLike | None = ...,
    source_radius: float | None = ...,
) -> FloatArray: ...
def arrival_times(
    speed: ArrayLike,
    sources: ArrayLike,
    *,
    spacing: ArrayLike = 1.0,
    order: int = 1,
    dtype: DTypeLike = np.float64,
    stop: ArrayLike | None = None,
    source_radius: float | None = None,
) -> FloatArray:
    """Times at which a front that leaves the sources at time 0 reaches each cell; inf if never.

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
        InvalidInput: if an argument is malformed, a source lies in a wall, or the speeds' range is
            too wide for the dtype.
    """
    precision = precision_of(dtype)
    check.integer(order, "order", at_least=1, at_most=2)
    radius = _radius(source_radius, order)
    field = speed_map(speed)
    cells = source_cells(sources, field)
    last = -1 if stop is None else int(flat_indices(stop, "stop", field.shape)[0])
    steps = spacings(spacing, field.ndim)
    check_range(*range_of(field), cells=field.size, spacing=steps, dtype=precision)
    march = _core.march_float32 if precision == np.float32 else _core.march_float64
    with check.enough_memory(f"speed: a grid of shape {field.shape}"):
        map_ = np.ascontiguousarray(field, precision)
        return march(map_, steps.tolist(), cells, order, radius, last)


@overload  # no type is both float32 and float64
def arrival_times_batch(  # type: ignore[overload-overlap]
    speeds: Sequence[ArrayLike],
    sources: Sequence[ArrayLike],
    *,
    spacing: ArrayLike = ...,
    order: int = ...,
    dtype: type[np.float32],
    source_radius: float | None = ...,
    threads: int = ...,
) -> list[NDArray[np.float32]]: ...
@overload
def arrival_times_batch(
    speeds: Sequence[ArrayLike],
    sources: Sequence[ArrayLike],
    *,
    spacing: ArrayLike = ...,
    order: int = ...,
    dtype: type[np.float64] = ...,
    source_radius: float | None = ...,
    threads: int = ...,
) -> list[Float64Array]: ...
@overload
def arrival_times_batch(
    speeds: Sequence[ArrayLike],
    sources: Sequence[ArrayLike],
    *,
    spacing: ArrayLike = ...,
    order: int = ...,
    dtype: DTypeLike,
    source_radius: float | None = ...,
    threads: int = ...,
) -> list[NDArray[np.float32]] | list[Float64Array]: ...
def arrival_times_batch(
    speeds: Sequence[ArrayLike],
    sources: Sequence[ArrayLike],
    *,
    spacing: ArrayLike = 1.0,
    order: int = 1,
    dtype: DTypeLike = np.float64,
    source_radius: float | None = None,
    threads: int = 1,
) -> list[NDArray[np.float32]] | list[Float64Array]:
    """The times of several problems, as `arrival_times` computes them one by one.

    Args:
        speeds: maps of one shape; a single map serves all sources.
        sources: one entry per problem; a single entry serves all maps.
        spacing: as in `arrival_times`.
        order: as in `arrival_times`.
        dtype: as in `arrival_times`.
        source_radius: as in `arrival_times`.
        threads: at least 1; the bits of the result do not depend on it.

    Returns:
        Times of the maps' shape, one array per problem.

    Raises:
        InvalidInput: as in `arrival_times`, and if there are not as many maps as sources.
    """
    precision = precision_of(dtype)
    check.integer(order, "order", at_least=1, at_most=2)
    check.integer(threads, "threads", at_least=1)
    radius = _radius(source_radius, order)
    maps = [speed_map(speed) for speed in _entries(speeds, "speeds")]
    starts = _entries(sources, "sources")
    count = _count(len(maps), len(starts))
    _check_shapes({field.shape for field in maps})
    steps = spacings(spacing, maps[0].ndim)
    for field in maps:
        check_range(*range_of(field), cells=field.size, spacing=steps, dtype=precision)
    fields = [k % len(maps) for k in range(count)]
    cells = [source_cells(starts[k % len(starts)], maps[fields[k]]) for k in range(count)]
    march = _core.march_batch_float32 if precision == np.float32 else _core.march_batch_float64
    with check.enough_memory(f"speeds: {count} grids of shape {maps[0].shape}"):
        arrays = [np.ascontiguousarray(field, precision) for field in maps]
        return march([arrays[k] for k in fields], steps.tolist(), cells, order, radius, threads)


# Any: maps and sources pass through here alike; each is checked where it is used.
def _entries(values: Sequence[Any], name: str) -> list[Any]:
    entries = list(values) if np.iterable(values) and not isinstance(values, str) else []
    if not entries:
        raise InvalidInput(f"{name}: expected a sequence, one entry per problem, got {values!r}")
    return entries


def _count(maps: int, sources: int) -> int:
    """Number of problems that the maps and sources make."""
    count = max(maps, sources)
    if {maps, sources} - {1, count}:
        raise InvalidInput(
            "sources: expected as many entries as speeds, or a single one of either, "
            f"got {sources} for {maps}"
        )
    return count


def _check_shapes(shapes: set[tuple[int, ...]]) -> None:
    if len(shapes) > 1:
        raise InvalidInput(f"speeds: expected maps of one shape, got {sorted(shapes)}")


def _radius(source_radius: float | None, order: int) -> float:
    if source_radius is None:
        return _SOURCE_RADIUS[order]
    return check.number(source_radius, "source_radius", at_least=0.0, at_most=_LARGEST_RADIUS)
