"""Paths along straight lines between way-points, whose corners are cut or stopped at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.trajectories import Spline
from leadthrough.trajectories.minimum_jerk import QUINTIC

# Directions that differ by less are the same: rounding of way-points on a straight line.
_SAME_DIRECTION = 1e-9
# Way-points that are nearer to each other in all coordinates, rad (m), are one: no encoder tells
# them apart, and the direction between them is rounding.
_COINCIDENT = 1e-9
# What is left of a line between two corners is a piece if knots can be told apart there.
_ULPS = 8.0 * np.finfo(np.float64).eps


def apart(points: Float64Array) -> NDArray[np.intp]:
    """Indices of the way-points that do not nearly coincide with the one kept before.

    The first is among them; so is the last, in place of the one that it coincides with, unless it
    repeats all.
    """
    kept = _core.rows_apart(np.ascontiguousarray(points), _COINCIDENT)
    last = len(points) - 1
    if (points[kept[-1]] != points[last]).any():
        return np.append(kept[: max(len(kept) - 1, 1)], last)
    return kept


def stops_of(points: Float64Array, *, blend: float, holds: Sequence[int]) -> list[int]:
    """Indices of the way-points at which the motion rests: the ends, those held, and corners.

    Args:
        points: way-points (n, d).
        blend: with more than 0 corners are cut, so that the motion does not rest there.
        holds: indices of the way-points to rest at.
    """
    stops = {0, *holds, len(points) - 1}
    if blend == 0.0 and len(points) > 2:
        steps = np.diff(points, axis=0)
        directions = steps / np.linalg.norm(steps, axis=1)[:, None]
        turns = np.abs(np.diff(directions, axis=0)).max(axis=1)
        stops.update((np.flatnonzero(turns > _SAME_DIRECTION) + 1).tolist())
    return sorted(stops)


def are_lines(points: Float64Array, stops: Sequence[int]) -> bool:
    """Whether the straight lines between stops lead through all way-points (n, d), in their order.

    Args:
        points: way-points.
        stops: indices of some of them, the first and the last among them.
    """
    line = np.minimum(np.searchsorted(stops, np.arange(len(points)), side="right"), len(stops) - 1)
    begin = points[list(stops)][line - 1]
    along, from_stop = points[list(stops)][line] - begin, points - begin
    squared = np.einsum("ij,ij->i", along, along)
    if not squared.all():
        return False
    share = np.einsum("ij,ij->i", from_stop, along) / squared
    beside = np.abs(from_stop - share[:, None] * along).max()
    return bool(beside <= _COINCIDENT and (np.diff(line + share) > 0.0).all())


def blended_path(points: Float64Array, blend: float) -> Spline:
    """Straight lines between way-points, with corners cut.

    The lines are passed at unit speed. A quintic with the lines' velocities and no acceleration at
    its ends leads around a corner, on no more than half of the lines beside it.

    Args:
        points: way-points (n, d), no two neighbours equal.
        blend: the largest distance from a corner, in every coordinate.
    """
    steps = np.diff(points, axis=0)
    lengths = np.sqrt(np.einsum("ij,ij->i", steps, steps))
    directions = steps / lengths[:, None]
    knots, pieces = [0.0], []
    begin = 0.0  # length of the line that the last corner took
    for i, (length, direction) in enumerate(zip(lengths, directions, strict=True)):
        last = i == len(lengths) - 1
        cut = 0.0 if last else _cut(directions, lengths, i, blend)
        if knots[-1] + (length - cut - begin) > knots[-1] * (1.0 + _ULPS):
            start = points[i] + begin * direction
            pieces.append(_piece([start, direction]))
            knots.append(knots[-1] + length - cut - begin)
        if cut > 0.0:
            pieces.append(_corner(points[i + 1], direction, directions[i + 1], cut))
            knots.append(knots[-1] + 2.0 * cut)
        begin = cut
    return Spline(np.array(knots), np.array(pieces))


def _cut(directions: Float64Array, lengths: Float64Array, i: int, blend: float) -> float:
    """How far before the corner after line i the quintic begins, and ends behind it.

    Its middle is 3/16 of that, times the change of direction, from the corner.
    """
    change = float(np.abs(directions[i + 1] - directions[i]).max())
    if change <= _SAME_DIRECTION:
        return 0.0
    return min(16.0 * blend / (3.0 * change), 0.5 * float(min(lengths[i], lengths[i + 1])))


def _corner(
    corner: Float64Array, before: Float64Array, after: Float64Array, cut: float
) -> Float64Array:
    """Quintic over 2 cut from corner - cut before to corner + cut after."""
    h = 2.0 * cut
    rise, speed = cut * (after - before), after - before
    powers = [
        (by_rise * rise + by_speed * h * speed) / h**power
        for power, (by_rise, _, by_speed) in enumerate(QUINTIC.tolist(), 3)
    ]
    return _piece([corner - cut * before, before, np.zeros_like(corner), *powers])


def _piece(rows: list[Float64Array]) -> Float64Array:
    table = np.zeros((6, len(rows[0])))
    table[: len(rows)] = rows
    return table
