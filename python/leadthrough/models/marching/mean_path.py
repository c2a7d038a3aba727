"""The path that demonstrations predict between a new start and a new goal.

Each demonstration is carried to the new ends in two ways, shifted and turned, and those that do
the task in the way of the nearest one are averaged over the arc length. The constants were found
on human handwriting.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.brief import Brief
from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length, by_arc_length

_SAMPLES = 1000
_TURNED_FRACTION = 1.0 / 3.0
# Between these ratios of a demonstration's chord to its length, turning fades in: a motion that
# returns to its start has no direction to turn from.
_RETURNING = (0.05, 0.1)
# Turning by more than 154 degrees or scaling by more than 5 says little about the new motion.
_LEAST_COSINE = -0.9
_SCALES = (0.2, 5.0)
# Demonstrations farther apart than this fraction of their length do the task in different ways.
_SAME_WAY = 0.1
# A path is moved at most so much farther than its ends.
MOST_DEVIATION = 1.45
# Nor does it leave the demonstrations by more than that; less than 1 leaves room for rounding.
_ROOM = 0.999


@dataclass(frozen=True, eq=False)
class MeanPath(Brief):
    """A predicted path.

    Attributes:
        path: (n, d), the mean of demonstrations that are evenly spaced in arc length.
        weights: (k,) of the demonstrations; 0 for those that do the task in another way.
        region: corners (lower, upper), (d,) each, around the demonstrations, as far from them as
            the ends are moved: smoothing may not lead out of it either.
    """

    path: Float64Array
    weights: Float64Array
    region: tuple[Float64Array, Float64Array]


def ways(
    paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array
) -> Iterator[MeanPath]:
    """The ways to do the task that were shown, that of the nearest start first.

    Each is the weighted mean of its demonstrations, carried to a new start and goal.

    Args:
        paths: of the demonstrations, each (n, d), at least one.
        start: (d,).
        goal: (d,).
    """
    curves = np.stack([by_arc_length(path, _SAMPLES) for path in paths])
    shifted = np.stack([with_ends(curve, start, goal) for curve in curves])
    length = float(np.mean([arc_length(path)[-1] for path in paths]))
    carried = _all_carried(curves, shifted, start, goal)
    usual = curves[:, [0, -1]].mean(axis=0)
    moved = float(np.linalg.norm(np.stack([start, goal]) - usual, axis=1).max())
    region = _region(curves, start, goal, _ROOM * moved)
    for chosen in _same_ways(shifted, curves[:, 0], start, length):
        weights = _weights(curves[:, 0], start, chosen)
        path = np.einsum("j,jnd->nd", weights, carried)
        if moved > 0.0:
            path = _bounded(path, _usual_way(curves, chosen, *usual), start, goal)
            path = np.clip(path, *region)
        yield MeanPath(path, weights, region)


def _region(
    curves: Float64Array, start: Float64Array, goal: Float64Array, room: float
) -> tuple[Float64Array, Float64Array]:
    """Corners around demonstrations (k, n, d), with room, and around start and goal."""
    ends = np.stack([start, goal])
    lower, upper = curves.min(axis=(0, 1)) - room, curves.max(axis=(0, 1)) + room
    return np.minimum(lower, ends.min(axis=0)), np.maximum(upper, ends.max(axis=0))


def _usual_way(
    curves: Float64Array, chosen: NDArray[np.bool_], start: Float64Array, goal: Float64Array
) -> Float64Array:
    """The mean (n, d) of those chosen among demonstrations (k, n, d) where the ends are usual."""
    shifted = np.stack([with_ends(curve, start, goal) for curve in curves])
    weights = _weights(curves[:, 0], start, chosen)
    return np.asarray(np.einsum("j,jnd->nd", weights, _all_carried(curves, shifted, start, goal)))


def _bounded(
    path: Float64Array, usual: Float64Array, start: Float64Array, goal: Float64Array
) -> Float64Array:
    """The path, drawn to the shifted usual one until it is no farther from that than its ends.

    Neither turning nor a change of weights then moves the way much more than the ends are moved.
    """
    shifted = with_ends(usual, start, goal)
    moved = max(float(np.linalg.norm(start - usual[0])), float(np.linalg.norm(goal - usual[-1])))
    bound = MOST_DEVIATION * moved
    off, change = shifted - usual, path - shifted
    if np.linalg.norm(off + change, axis=1).max() <= bound:
        return path
    # The largest fraction of the change with |off + fraction * change| <= bound everywhere.
    a, b = (change**2).sum(axis=1), (off * change).sum(axis=1)
    c = np.minimum((off**2).sum(axis=1) - bound**2, 0.0)
    inside = a > 0.0
    roots = (-b[inside] + np.sqrt(b[inside] ** 2 - a[inside] * c[inside])) / a[inside]
    return np.asarray(shifted + min(float(roots.min()), 1.0) * change)


def with_ends(curve: Float64Array, start: Float64Array, goal: Float64Array) -> Float64Array:
    """The curve with the offsets of both ends blended linearly over its length."""
    u = np.linspace(0.0, 1.0, len(curve))[:, None]
    return np.asarray(curve + (1 - u) * (start - curve[0]) + u * (goal - curve[-1]))


def _carried(
    curve: Float64Array, shifted: Float64Array, start: Float64Array, goal: Float64Array
) -> Float64Array:
    turned = _turned(curve, start, goal)
    if turned is None:
        return shifted
    chord = float(np.linalg.norm(curve[-1] - curve[0])) / float(arc_length(curve)[-1])
    directed = (chord - _RETURNING[0]) / (_RETURNING[1] - _RETURNING[0])
    fraction = _TURNED_FRACTION * min(max(directed, 0.0), 1.0)
    return np.asarray((1.0 - fraction) * shifted + fraction * turned)


def _turned(curve: Float64Array, start: Float64Array, goal: Float64Array) -> Float64Array | None:
    """The curve turned about the goal and scaled so that it begins at the start, or None.

    The rotation takes one chord onto the other in their plane, in any dimension.
    """
    old, new = curve[0] - curve[-1], start - goal
    lengths = np.linalg.norm(old), np.linalg.norm(new)
    if min(lengths) == 0.0 or not _SCALES[0] < lengths[1] / lengths[0] < _SCALES[1]:
        return None
    a, b = old / lengths[0], new / lengths[1]
    cosine = float(a @ b)
    if cosine < _LEAST_COSINE:
        return None
    y = curve - curve[-1]
    bisector = a + b
    rotated = y - np.outer(y @ bisector, bisector) / (1 + cosine) + 2 * np.outer(y @ a, b)
    return np.asarray(goal + lengths[1] / lengths[0] * rotated)


def _all_carried(
    curves: Float64Array, shifted: Float64Array, start: Float64Array, goal: Float64Array
) -> Float64Array:
    return np.stack(
        [_carried(curve, moved, start, goal) for curve, moved in zip(curves, shifted, strict=True)]
    )


def _same_ways(
    shifted: Float64Array, starts: Float64Array, start: Float64Array, length: float
) -> Iterator[NDArray[np.bool_]]:
    """Which demonstrations are connected by small steps, those with the nearest start first."""
    gaps = np.sqrt(((shifted[:, None] - shifted[None]) ** 2).sum(axis=3).mean(axis=2))
    neighbours = gaps < _SAME_WAY * length
    distance = np.linalg.norm(starts - start, axis=1)
    left = np.ones(len(shifted), dtype=bool)
    while left.any():
        chosen = np.zeros(len(shifted), dtype=bool)
        chosen[int(np.argmin(np.where(left, distance, np.inf)))] = True
        for _ in shifted:
            chosen = chosen | neighbours[chosen].any(axis=0)
        yield chosen
        left &= ~chosen


def _weights(starts: Float64Array, start: Float64Array, chosen: NDArray[np.bool_]) -> Float64Array:
    """Gaussian weights in the distance of the starts, as wide as these are spread; sum 1."""
    squared = ((starts - start) ** 2).sum(axis=1)
    spread = float(starts.var(axis=0, ddof=1).sum()) if len(starts) > 1 else 0.0
    nearer = np.zeros(len(starts))
    if spread > 0.0:
        nearer = -(squared - squared[chosen].min()) / (2.0 * spread)
    weights = np.where(chosen, np.exp(np.where(chosen, nearer, 0.0)), 0.0)
    return np.asarray(weights / weights.sum())
