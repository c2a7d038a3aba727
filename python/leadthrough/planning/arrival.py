"""Arrival times of a front: the eikonal equation |grad T| = 1 / speed, by fast marching.

Source: Sethian 1996, "A fast marching level set method for monotonically advancing fronts"; second
order: Sethian 1999, "Fast marching methods".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from leadthrough import _core, check
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import spacings
from leadthrough.planning.march_input import (
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


def arrival_times(
    speed: Any,
    sources: Any,
    *,
    spacing: Any = 1.0,
    order: int = 1,
    dtype: DTypeLike = np.float64,
    stop: Any = None,
    source_radius: float | None = None,
) -> NDArray[Any]:
    """Time at which a front that leaves the sources at time 0 reaches each cell; inf if never.

    speed: 2-D or 3-D, length per time, >= 0; 0 is a wall, and the slowest other speed must be above
    1e-15 of the fastest. sources: (d,) or (k, d) cells' indices. spacing: (d,) or one number, the
    length between neighbouring cells. order: 1 or 2. dtype: float32 or float64 of times and
    arithmetic. stop: (d,) a cell; cells that the front reaches later stay inf, which saves time.
    source_radius: cells (of the smallest spacing), 0 to 50; within it times are exact distances
    over the source's speed, as far as no cell of another speed comes near and at most half way to
    the next source. By default 0 at order 1 and 8 at order 2.
    Returns an array of the shape of `speed`. Raises InvalidInput.
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
    return march(np.ascontiguousarray(field, precision), steps.tolist(), cells, order, radius, last)


def _entries(values: Any, name: str) -> list[Any]:
    entries = list(values) if np.iterable(values) and not isinstance(values, str) else []
    if not entries:
        raise InvalidInput(f"{name}: expected a sequence with one entry a problem, got {values!r}")
    return entries


def _radius(source_radius: float | None, order: int) -> float:
    if source_radius is None:
        return _SOURCE_RADIUS[order]
    return check.number(source_radius, "source_radius", at_least=0.0, at_most=_LARGEST_RADIUS)


def arrival_times_batch(
    speeds: Sequence[Any],
    sources: Sequence[Any],
    *,
    spacing: Any = 1.0,
    order: int = 1,
    dtype: DTypeLike = np.float64,
    source_radius: float | None = None,
    threads: int = 1,
) -> list[NDArray[Any]]:
    """The times of several problems, as `arrival_times` gives them one by one, on several threads.

    speeds: maps of one shape. sources: one entry a problem. A single map serves all sources, a
    single entry of sources all maps. threads: at least 1; the result's bits do not depend on it.
    The rest as in `arrival_times`. Raises InvalidInput.
    """
    precision = precision_of(dtype)
    check.integer(order, "order", at_least=1, at_most=2)
    check.integer(threads, "threads", at_least=1)
    radius = _radius(source_radius, order)
    maps = [speed_map(speed) for speed in _entries(speeds, "speeds")]
    starts = _entries(sources, "sources")
    count = max(len(maps), len(starts))
    if {len(maps), len(starts)} - {1, count}:
        raise InvalidInput(
            "sources: expected as many entries as speeds, or a single one of either, "
            f"got {len(starts)} for {len(maps)}"
        )
    shapes = {field.shape for field in maps}
    if len(shapes) > 1:
        raise InvalidInput(f"speeds: expected maps of one shape, got {sorted(shapes)}")
    steps = spacings(spacing, maps[0].ndim)
    for field in maps:
        check_range(*range_of(field), cells=field.size, spacing=steps, dtype=precision)
    arrays = [np.ascontiguousarray(field, precision) for field in maps]
    pairs = [
        (k % len(maps), source_cells(starts[k % len(starts)], maps[k % len(maps)]))
        for k in range(count)
    ]
    march = _core.march_batch_float32 if precision == np.float32 else _core.march_batch_float64
    return march(
        [arrays[k] for k, _ in pairs],
        steps.tolist(),
        [cells for _, cells in pairs],
        order,
        radius,
        threads,
    )
