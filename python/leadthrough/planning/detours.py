"""Detours of a path around obstacles, which leave it and rejoin it where they block it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array, NoPath
from leadthrough.planning import maps
from leadthrough.planning.grid import Grid
from leadthrough.planning.maps import Scales, slowed_at
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Shape

# A path no longer than this fraction of its coordinates stands still, up to rounding.
_STILL = 1e-9


def detoured(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> Float64Array:
    """A path with detours around obstacles through its tube; itself where there is none."""
    parts = _parts(path, grid, obstacles, scales)
    if len(parts) == 1 and parts[0][0] is path:
        return path
    points = [points for points, _ in parts]
    return np.concatenate([points[0], *(each[1:] for each in points[1:])])


def around(
    path: Float64Array, obstacles: Sequence[Shape], pieces: int
) -> tuple[Float64Array, Float64Array, float] | None:
    """A smooth path clear of obstacles, the given one's fraction at each point, and its stretch."""
    length = float(arc_length(path)[-1])
    if length <= _STILL * float(np.abs(path).max()):
        if is_free(path, obstacles):
            return None
        raise NoPath(f"start: {path[0]} lies in an obstacle", reason="start_in_wall")
    grid, scales = maps.grid_over([path], obstacles, maps.scales_of(length))
    parts = _parts(path, grid, obstacles, scales)
    if len(parts) == 1 and parts[0][0] is path:
        return None
    points, fractions = [path[:1]], [np.zeros(1)]
    for part, rows in parts:
        covered = arc_length(part)
        along = covered / (covered[-1] or 1.0)
        first, last = (row / (len(path) - 1) for row in rows)
        points.append(part[1:])
        fractions.append(first + (last - first) * along[1:])
    joined = np.concatenate(points)
    field = maps.tube_field(path, grid, obstacles, scales)
    knots = max(maps.CELLS_PER_KNOT * float(grid.spacing.max()), length / pieces)
    smooth = maps.smooth_between_walls(joined, field, knots)
    before, after = arc_length(joined), arc_length(smooth)
    at = np.interp(after / after[-1], before / before[-1], np.concatenate(fractions))
    return smooth, at, float(after[-1]) / length


def is_free(path: Float64Array, obstacles: Sequence[Shape]) -> bool:
    """Whether the points of a path (n, d) lie outside all obstacles."""
    return maps.min_distance(path, obstacles) > 0.0


def _parts(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> list[tuple[Float64Array, tuple[int, int]]]:
    """Consecutive parts of a path or detours, with the first and the last row that they replace."""
    whole = (0, len(path) - 1)
    influenced = slowed_at(path, grid, obstacles, scales) if obstacles else np.zeros(1, dtype=bool)
    if not influenced.any():
        return [(path, whole)]
    try:
        return [
            (
                _detour(path[a : b + 1], grid, obstacles, scales) if blocked else path[a : b + 1],
                (a, b),
            )
            for a, b, blocked in _stretches(influenced)
        ]
    except NoPath:
        # An end of a detour may be enclosed although start and goal are not.
        return [(maps.quickest_in_tube(path, grid, obstacles, scales), whole)]


def _detour(
    stretch: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> Float64Array:
    # As wide a tube as the detour may become: it leaves and rejoins the path gently.
    wide = replace(scales, radius=0.5 * float(arc_length(stretch)[-1]))
    return maps.quickest_in_tube(stretch, grid, obstacles, wide)


def _stretches(influenced: NDArray[np.bool_]) -> list[tuple[int, int, bool]]:
    """First and last rows of consecutive parts, and whether each is a detour."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], influenced, [0]]))).reshape(-1, 2)
    last = len(influenced) - 1
    bounds, blocked = [0], []
    for k, (first, end) in enumerate(edges):
        extra = (end - first + 1) // 2
        before = 0 if k == 0 else -(-(edges[k - 1, 1] + first) // 2)
        after = last if k + 1 == len(edges) else (end + edges[k + 1, 0]) // 2
        a, b = max(first - extra, before, 0), min(end + extra, after, last)
        if a > bounds[-1]:
            bounds.append(a)
            blocked.append(False)
        bounds.append(b)
        blocked.append(True)
    if bounds[-1] < last:
        bounds.append(last)
        blocked.append(False)
    return [
        (int(a), int(b), on) for (a, b), on in zip(pairwise(bounds), blocked, strict=True) if b > a
    ]
