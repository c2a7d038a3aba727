"""The input of a march, checked: speeds, sources and a precision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import MOST_CELLS

FloatArray = NDArray[np.float32] | NDArray[np.float64]
# Any: numbers of every type may come in, and which precision they get is known only then.
Numbers = NDArray[Any]
Precision = np.dtype[Any]

# Beyond this ratio squares of times leave the range of float32.
MOST_SPEED_RATIO = 1e15

# An ArrivalField counts in units of up to this times its fastest speed.
_HEADROOM = 4.0


def precision_of(dtype: DTypeLike) -> Precision:
    """The type in which a march computes, float32 or float64; raises InvalidInput for others."""
    try:
        precision = np.dtype(dtype)
    except TypeError:
        raise InvalidInput(f"dtype: expected float32 or float64, got {dtype!r}") from None
    if precision not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise InvalidInput(f"dtype: expected float32 or float64, got {precision}")
    return precision


def regular(value: ArrayLike, name: str) -> Numbers:
    """`value` as an array of its own type; raises InvalidInput for ragged rows."""
    try:
        return np.asarray(value)
    except ValueError:
        raise InvalidInput(f"{name}: expected a regular array, got ragged rows") from None


def speed_map(speed: ArrayLike) -> Numbers:
    """`speed` as a 2-D or 3-D array of finite numbers >= 0; raises InvalidInput for others."""
    field = regular(speed, "speed")
    if field.dtype.kind not in "fiu" or field.ndim not in (2, 3) or field.size == 0:
        raise InvalidInput(
            "speed: expected a 2-D or 3-D array of numbers, "
            f"got shape {field.shape} of {field.dtype}"
        )
    if field.size > MOST_CELLS:
        raise InvalidInput(f"speed: expected at most {MOST_CELLS:.0e} cells, got {field.size}")
    return finite_speeds(field)


def finite_speeds(field: Numbers) -> Numbers:
    """`field` if its numbers are finite and >= 0; raises InvalidInput otherwise."""
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
    """Checks that times can be told apart and stay in the range of a precision."""
    if slowest < fastest / MOST_SPEED_RATIO:
        raise InvalidInput(
            f"speed: expected 0 or at least {1 / MOST_SPEED_RATIO:.0e} times the fastest, "
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
    cells = regular(indices, name)
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
