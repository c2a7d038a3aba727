"""Paths along straight lines between way-points, whose corners are cut or stopped at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.trajectories import Spline
from leadthrough.trajectories.minimum_jerk import QUINTIC

# Directions that differ by less are the same: rounding of way-points on a straight line.
_SAME_DIRECTION = 1e-9


def stops_of(points: Float64Array, *, blend: float, holds: Sequence[int]) -> list[int]:
    """Indices of the way-points at which the motion rests: the ends, those held, and corners.

    Args:
        points: way-points (n, d).
        blend: with more than 0 corners are cut, so that the motion does not rest there.
        holds: indices of the way-points to rest at.
    """
    stops = [0, *holds, len(points) - 1]
    if blend == 0.0:
        stops += [i for i in range(1, len(points) - 1) if _turn(points, i) > _SAME_DIRECTION]
    return sorted(set(stops))


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
        if length - cut > begin:
            start = points[i] + begin * direction
            pieces.append(_piece([start, direction]))
            knots.append(knots[-1] + length - cut - begin)
        if cut > 0.0:
            pieces.append(_corner(points[i + 1], direction, directions[i + 1], cut))
            knots.append(knots[-1] + 2.0 * cut)
        begin = cut
    return Spline(np.array(knots), np.array(pieces))


def _turn(points: Float64Array, i: int) -> float:
    before, after = points[i] - points[i - 1], points[i + 1] - points[i]
    return float(np.abs(after / np.linalg.norm(after) - before / np.linalg.norm(before)).max())


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
