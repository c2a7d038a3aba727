"""Arrival times of a front: the eikonal equation |grad T| = 1 / speed, by fast marching.

Source: Sethian 1996, "A fast marching level set method for monotonically advancing fronts"; second
order: Sethian 1999, "Fast marching methods".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import MOST_CELLS, spacings

# Beyond this ratio squares of times leave the range of float32.
MOST_SPEED_RATIO = 1e15


def arrival_times(
    speed: Any,
    sources: Any,
    *,
    spacing: Any = 1.0,
    order: int = 1,
    dtype: DTypeLike = np.float64,
    stop: Any = None,
) -> NDArray[Any]:
    """Time at which a front that leaves the sources at time 0 reaches each cell; inf if never.

    speed: 2-D or 3-D, length per time, >= 0; 0 is a wall, and the slowest other speed must be above
    1e-15 of the fastest. sources: (d,) or (k, d) cells' indices. spacing: (d,) or one number, the
    length between neighbouring cells. order: 1 or 2. dtype: float32 or float64 of times and
    arithmetic. stop: (d,) a cell; cells that the front reaches later stay inf, which saves time.
    Returns an array of the shape of `speed`. Raises InvalidInput.
    """
    precision = np.dtype(dtype)
    if precision not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise InvalidInput(f"dtype: expected float32 or float64, got {precision}")
    check.integer(order, "order", at_least=1, at_most=2)
    field = _speed(speed)
    cells = _cells(sources, "sources", field.shape)
    walls = field.ravel()[cells] == 0.0
    if walls.any():
        at = np.unravel_index(cells[int(np.argmax(walls))], field.shape)
        raise InvalidInput(
            f"sources: expected cells of speed > 0, got a wall at {tuple(int(i) for i in at)}"
        )
    last = -1 if stop is None else int(_cells(stop, "stop", field.shape)[0])
    steps = spacings(spacing, field.ndim)
    _check_range(field, steps, precision)
    march = _core.march_float32 if precision == np.float32 else _core.march_float64
    return march(
        np.ascontiguousarray(field, precision),
        steps.tolist(),
        cells,
        np.zeros(len(cells)),
        order,
        last,
    )


def _speed(speed: Any) -> NDArray[Any]:
    field = np.asarray(speed)
    if field.dtype.kind not in "fiu" or field.ndim not in (2, 3) or field.size == 0:
        raise InvalidInput(
            "speed: expected a 2-D or 3-D array of numbers, "
            f"got shape {field.shape} of {field.dtype}"
        )
    if field.size > MOST_CELLS:
        raise InvalidInput(f"speed: expected at most {MOST_CELLS:.0e} cells, got {field.size}")
    if not (field.min() >= 0 and field.max() < np.inf):
        at = tuple(int(i) for i in np.argwhere(~((field >= 0) & (field < np.inf)))[0])
        raise InvalidInput(f"speed: expected finite numbers >= 0, got {field[at]} at {at}")
    return field


def _check_range(speed: NDArray[Any], spacing: Float64Array, dtype: np.dtype[Any]) -> None:
    """Raises InvalidInput where the times could not be told apart or leave the range of dtype."""
    least, most = float(speed.min()), float(speed.max())
    slowest = least if least > 0.0 else float(np.where(speed > 0, speed, np.inf).min())
    if slowest < most / MOST_SPEED_RATIO:
        raise InvalidInput(
            f"speed: expected 0 or at least {1 / MOST_SPEED_RATIO:.0e} of the fastest, {most}, "
            f"got {slowest}; make such cells walls or raise them"
        )
    limits = np.finfo(dtype)
    with np.errstate(over="ignore"):
        quickest = spacing.min() / np.float64(most)
        longest = spacing.max() / np.float64(slowest) * speed.size
    if not (limits.tiny < min(quickest, slowest) and max(longest, most) < limits.max):
        raise InvalidInput(
            f"speed: expected times in the range of {dtype}, got speeds from {slowest} to {most}"
        )


def _cells(indices: Any, name: str, shape: tuple[int, ...]) -> NDArray[np.int64]:
    cells = np.asarray(indices)
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
