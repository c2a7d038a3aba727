"""Regular grids of cells in space."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr

CellArray = NDArray[np.int64]
# Numbers of cells in C order, (n,).
CellNumbers = NDArray[np.int64]

# A march over this many cells takes some 10 s and 5 GB; a finer one is a mistake in the spacing.
MAX_CELLS = 200_000_000


@dataclass(frozen=True, eq=False, init=False)
class Grid(ShortRepr):
    """Cells about the points origin + index * spacing, in C order.

    Attributes:
        origin: centre of the first cell (d,), in the unit of the points; d is 2 or 3.
        spacing: distance between neighbours' centres, (d,), > 0; one number holds for every axis.
        shape: number of cells along every axis, (d,), at most 2e8 in all.
    """

    origin: Float64Array
    spacing: Float64Array
    shape: tuple[int, ...]

    def __init__(self, origin: ArrayLike, spacing: ArrayLike, shape: Iterable[int]) -> None:
        first = check.frozen(origin, "origin", shape=("d",))
        if len(first) not in (2, 3):
            raise InvalidInput(f"origin: expected 2 or 3 numbers, got {len(first)}")
        steps = spacings(spacing, len(first))
        vars(self).update(origin=first, spacing=steps, shape=_shape(shape, len(first)))

    @classmethod
    def covering(cls, points: ArrayLike, *, margin: float, spacing: ArrayLike) -> Grid:
        """The smallest grid whose cells' centres reach beyond points by a margin on all sides.

        Centres lie on whole multiples of the spacing, so that grids of one spacing coincide.

        Args:
            points: to cover, (n, d).
            margin: in the points' unit, >= 0.
            spacing: distance between neighbours' centres, > 0, (d,) or one number.

        Raises:
            InvalidInput: if the grid would have too many cells.
        """
        p = check.array(points, "points", shape=("n", "d"))
        if len(p) == 0 or p.shape[1] not in (2, 3):
            raise InvalidInput(f"points: expected shape (n, 2) or (n, 3), got {p.shape}")
        room = check.number(margin, "margin", at_least=0.0)
        steps = spacings(spacing, p.shape[1])
        with np.errstate(over="ignore"):
            low = np.floor((p.min(axis=0) - room) / steps)
            high = np.ceil((p.max(axis=0) + room) / steps)
            counts = high - low + 1
        if not counts.prod() <= MAX_CELLS:
            raise InvalidInput(
                f"spacing: expected a grid of at most {MAX_CELLS:.0e} cells, "
                f"got one of {' x '.join(f'{count:.6g}' for count in counts)}"
            )
        return cls(low * steps, steps, tuple(int(count) for count in counts))

    @property
    def dimensions(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.shape)

    @property
    def compiled(self) -> core.Cells:
        """The cells as the compiled core takes them."""
        return core.Cells(self.shape, self.spacing.tolist(), self.origin.tolist())

    def centres(self) -> Float64Array:
        """Centres of all cells, (*shape, d)."""
        axes = [
            start + step * np.arange(count)
            for start, step, count in zip(self.origin, self.spacing, self.shape, strict=True)
        ]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    def coordinates(self, points: ArrayLike) -> Float64Array:
        """Continuous indices (n, d) of points: whole numbers at cells' centres.

        Args:
            points: (n, d).
        """
        p = check.array(points, "points", shape=("n", self.dimensions))
        return np.asarray((p - self.origin) / self.spacing)

    def points_at(self, coordinates: ArrayLike) -> Float64Array:
        """Points (n, d) at continuous indices.

        Args:
            coordinates: (n, d), whole numbers at cells' centres.
        """
        c = check.array(coordinates, "coordinates", shape=("n", self.dimensions))
        return np.asarray(self.origin + c * self.spacing)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point lies in a cell of the grid, (n,).

        Args:
            points: (n, d).
        """
        nearest = np.floor(self.coordinates(points) + 0.5)
        return np.asarray(((nearest >= 0) & (nearest < self.shape)).all(axis=1))

    def cells_of(self, points: ArrayLike) -> CellArray:
        """Indices (n, d) of the cells that points lie in.

        Args:
            points: (n, d).

        Raises:
            InvalidInput: if a point lies outside the grid; ask `contains` first.
        """
        inside = self.contains(points)
        if not inside.all():
            outside = np.asarray(points, dtype=np.float64)[int(np.argmin(inside))]
            last = self.origin + self.spacing * (np.array(self.shape) - 1)
            raise InvalidInput(
                f"points: expected points in the grid, from {self.origin} to {last}, got {outside}"
            )
        return np.floor(self.coordinates(points) + 0.5).astype(np.int64)

    def numbers_of(self, cells: CellArray) -> CellNumbers:
        """Numbers (n,), in C order, of cells of the grid (n, d)."""
        return np.asarray(np.ravel_multi_index(tuple(cells.T), self.shape), dtype=np.int64)


def spacings(spacing: ArrayLike, dimensions: int) -> Float64Array:
    """A spacing for every axis, (dimensions,), read-only; one number holds for all axes."""
    raw = check.array(spacing, "spacing", shape=("d",)) if check.rank(spacing) else None
    steps = np.full(dimensions, check.number(spacing, "spacing")) if raw is None else raw.copy()
    if steps.shape != (dimensions,):
        raise InvalidInput(f"spacing: expected {dimensions} numbers, got {len(steps)}")
    for step in steps:
        check.number(float(step), "spacing", above=0.0)
    return check.freeze(steps)


def _shape(shape: Iterable[int], dimensions: int) -> tuple[int, ...]:
    if not np.iterable(shape) or isinstance(shape, str):
        raise InvalidInput(f"shape: expected {dimensions} integers, got {shape!r}")
    counts = tuple(check.integer(count, "shape", at_least=1) for count in shape)
    if len(counts) != dimensions:
        raise InvalidInput(f"shape: expected {dimensions} integers, got {len(counts)}")
    if math.prod(counts) > MAX_CELLS:
        raise InvalidInput(f"shape: expected at most {MAX_CELLS:.0e} cells, got {counts}")
    return counts


def bounds_of(cells: NDArray[np.bool_]) -> tuple[slice, ...] | None:
    """The smallest box around the True cells, None if there are none."""
    part: list[slice] = []
    for axis in range(cells.ndim):
        # Axes already searched are cut, so that the next one searches fewer cells.
        inside = cells[tuple(part)]
        others = tuple(k for k in range(cells.ndim) if k != axis)
        where = np.flatnonzero(inside.any(axis=others))
        if len(where) == 0:
            return None
        part.append(slice(int(where[0]), int(where[-1]) + 1))
    return tuple(part)


def check_grid(grid: object) -> Grid:
    if not isinstance(grid, Grid):
        raise check.refused("grid", "a Grid", type(grid).__name__)
    return grid
