"""Paths with an end far outside the map: straight up to it, and smooth where they enter it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_field import SpeedField, speeds_at
from leadthrough.preprocess.resample import arc_length
from leadthrough.preprocess.smooth_path import smooth_path
from leadthrough.shapes import Shape

# The way outside that is smoothed with the path inside, in knots: its corner at the map's border
# then vanishes.
_KNOTS = 6.0
# Points outside are farther apart by this factor: the way is straight there.
_SPARSER = 3.0


def clear_outside(
    path: Float64Array, grid: Grid, obstacles: Sequence[Shape], clearance: float
) -> bool:
    """Whether a path (n, d) keeps a clearance from obstacles on its ways outside a grid."""
    inside = grid.contains(path[[0, -1]])
    ways = [(path[0], path[1])] * (not inside[0]) + [(path[-1], path[-2])] * (not inside[1])
    return all(_is_clear(*way, obstacles, clearance) for way in ways)


def _is_clear(
    start: Float64Array, end: Float64Array, obstacles: Sequence[Shape], clearance: float
) -> bool:
    """Whether a segment keeps its distance; it is walked along by as much as is free."""
    length = float(np.linalg.norm(end - start))
    at = 0.0
    while obstacles and at < length:
        point = np.zeros((1, 3))
        point[0, : len(start)] = start + (at / length) * (end - start)
        free = min(float(each.distance(point)[0]) for each in obstacles)
        if free < clearance:
            return False
        at += max(free - 0.5 * clearance, 0.5 * clearance)
    return True


def smooth_between_walls(
    path: Float64Array, field: SpeedField, knot_spacing: float
) -> Float64Array:
    """A path (n, d) made smooth as far as no wall is touched."""
    grid = field.grid
    inside = grid.contains(path[[0, -1]])
    if not inside[1]:
        return smooth_between_walls(path[::-1], field, knot_spacing)[::-1]

    def is_free(points: Float64Array) -> bool:
        cells = grid.cells_of(points[grid.contains(points)])
        return bool(speeds_at(field, cells).all())

    if inside[0]:
        return smooth_path(path, knot_spacing=knot_spacing, accept=is_free)
    way = path[1] - path[0]
    straight = max(1.0 - _KNOTS * knot_spacing / float(np.linalg.norm(way)), 0.0)
    turn = path[0] + straight * way
    rest = smooth_path(
        np.concatenate([turn[None], path[1:]]), knot_spacing=knot_spacing, accept=is_free
    )
    step = float(arc_length(rest)[-1]) / (len(rest) - 1)
    count = int(np.ceil(float(np.linalg.norm(turn - path[0])) / (_SPARSER * step)))
    ahead = path[0] + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (turn - path[0])
    return np.concatenate([ahead, rest])
