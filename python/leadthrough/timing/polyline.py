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
    """Indices of the way-points that do not nearly coincide with the one kept before."""
    kept = _core.rows_apart(np.ascontiguousarray(points), _COINCIDENT)
    last = len(points) - 1
    if (points[kept[-1]] != points[last]).any():
        return np.append(kept[: max(len(kept) - 1, 1)], last)
    return kept


def stops_of(points: Float64Array, *, blend: float, holds: Sequence[int]) -> list[int]:
    """Indices of the way-points at which the motion rests: the ends, those held, and corners."""
    stops = {0, *holds, len(points) - 1}
    if blend == 0.0 and len(points) > 2:
        steps = np.diff(points, axis=0)
        directions = steps / np.linalg.norm(steps, axis=1)[:, None]
        turns = np.abs(np.diff(directions, axis=0)).max(axis=1)
        stops.update((np.flatnonzero(turns > _SAME_DIRECTION) + 1).tolist())
    return sorted(stops)


def are_lines(points: Float64Array, stops: Sequence[int]) -> bool:
    """Whether straight lines between stops pass all way-points (n, d) in order."""
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
    """Straight lines between way-points, with corners cut."""
    steps = np.diff(points, axis=0)
    lengths = np.sqrt(np.einsum("ij,ij->i", steps, steps))
    directions = steps / lengths[:, None]
    inner = _cuts(directions, lengths, blend)
    cuts = np.concatenate([[0.0], inner, [0.0]])
    knots, kept = _knots(lengths, cuts)
    pieces = np.zeros((2 * len(lengths) - 1, 6, points.shape[1]))
    pieces[::2, 0] = points[:-1] + cuts[:-1, None] * directions
    pieces[::2, 1] = directions
    cut = inner > 0.0
    pieces[1::2][cut] = _corners(
        points[1:-1][cut], directions[:-1][cut], directions[1:][cut], inner[cut]
    )
    return Spline(np.array(knots), pieces[kept])


def _cuts(directions: Float64Array, lengths: Float64Array, blend: float) -> Float64Array:
    """How far before each corner (corners,) its quintic begins, and how far behind it ends."""
    change = np.abs(np.diff(directions, axis=0)).max(axis=1)
    turns = change > _SAME_DIRECTION
    most = 16.0 * blend / (3.0 * np.where(turns, change, 1.0))
    return np.where(turns, np.minimum(most, 0.5 * np.minimum(lengths[:-1], lengths[1:])), 0.0)


def _knots(lengths: Float64Array, cuts: Float64Array) -> tuple[list[float], list[int]]:
    """The knots of lines and corners in turn, and which of these 2 lines - 1 pieces there are."""
    knots, kept = [0.0], list[int]()
    cut_at = cuts.tolist()
    for i, (length, before, after) in enumerate(
        zip(lengths.tolist(), cut_at[:-1], cut_at[1:], strict=True)
    ):
        if knots[-1] + (length - after - before) > knots[-1] * (1.0 + _ULPS):
            kept.append(2 * i)
            knots.append(knots[-1] + length - after - before)
        if after > 0.0:
            kept.append(2 * i + 1)
            knots.append(knots[-1] + 2.0 * after)
    return knots, kept


def _corners(
    corners: Float64Array, before: Float64Array, after: Float64Array, cuts: Float64Array
) -> Float64Array:
    """Quintics (corners, 6, d) over 2 cut from corner - cut before to corner + cut after."""
    cut, width, turn = cuts[:, None], 2.0 * cuts[:, None], after - before
    table = np.zeros((len(corners), 6, corners.shape[1]))
    table[:, 0], table[:, 1] = corners - cut * before, before
    for power, (by_rise, _, by_speed) in enumerate(QUINTIC.tolist(), 3):
        # Powers of numbers, as those of arrays have other bits on other processors.
        scale = np.array([each**power for each in width[:, 0].tolist()])[:, None]
        table[:, power] = (by_rise * (cut * turn) + by_speed * width * turn) / scale
    return table
