"""The path that demonstrations predict between a new start and a new goal.

Each demonstration is carried to the new ends in two ways, shifted and turned, and those that do
the task in the way of the nearest one are averaged over the arc length. The constants were found
on human handwriting.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length, by_arc_length

_SAMPLES = 1000
_TURNED_FRACTION = 1.0 / 3.0
# Turning by more than 154 degrees or scaling by more than 5 says little about the new motion.
_LEAST_COSINE = -0.9
_SCALES = (0.2, 5.0)
# Demonstrations farther apart than this fraction of their length do the task in different ways.
_SAME_WAY = 0.1
# A mean path is trusted where a demonstration's ends are nearer to start and goal than this
# fraction of the distance between these, or, for motions that return, of its own length. Farther
# off the demonstrations say little about the way, and bending them to it gives detours.
_NEAR_OF_DISTANCE = 0.5
_NEAR_OF_LENGTH = 0.1


@dataclass(frozen=True, eq=False)
class MeanPath:
    """A predicted path.

    Attributes:
        path: (n, d), the mean of demonstrations that are evenly spaced in arc length.
        weights: (k,) of the demonstrations; 0 for those that do the task in another way.
    """

    path: Float64Array
    weights: Float64Array


def predict(paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array) -> MeanPath:
    """The weighted mean of the demonstrations, each carried to a new start and goal.

    Args:
        paths: of the demonstrations, each (n, d), at least one.
        start: (d,).
        goal: (d,).
    """
    curves = np.stack([by_arc_length(path, _SAMPLES) for path in paths])
    shifted = np.stack([_shifted(curve, start, goal) for curve in curves])
    length = float(np.mean([arc_length(path)[-1] for path in paths]))
    weights = _weights(curves[:, 0], start, _same_way(shifted, curves[:, 0], start, length))
    carried = np.stack(
        [_carried(curve, moved, start, goal) for curve, moved in zip(curves, shifted, strict=True)]
    )
    return MeanPath(np.einsum("j,jnd->nd", weights, carried), weights)


def is_trusted(paths: Iterable[Float64Array], start: Float64Array, goal: Float64Array) -> bool:
    """Whether a demonstration's ends lie near enough to start and goal to predict the way.

    Args:
        paths: each (n, d).
        start: (d,).
        goal: (d,).
    """
    distance = float(np.linalg.norm(goal - start))
    ends = np.stack([start, goal])
    for path in paths:
        gaps = np.linalg.norm(path[[0, -1]] - ends, axis=1)
        length = float(arc_length(path)[-1])
        if gaps.max() <= max(_NEAR_OF_DISTANCE * distance, _NEAR_OF_LENGTH * length):
            return True
    return False


def _shifted(curve: Float64Array, start: Float64Array, goal: Float64Array) -> Float64Array:
    """The curve with the offsets of both ends blended linearly over its length."""
    u = np.linspace(0.0, 1.0, len(curve))[:, None]
    return np.asarray(curve + (1 - u) * (start - curve[0]) + u * (goal - curve[-1]))


def _carried(
    curve: Float64Array, shifted: Float64Array, start: Float64Array, goal: Float64Array
) -> Float64Array:
    turned = _turned(curve, start, goal)
    if turned is None:
        return shifted
    return np.asarray((1.0 - _TURNED_FRACTION) * shifted + _TURNED_FRACTION * turned)


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


def _same_way(
    shifted: Float64Array, starts: Float64Array, start: Float64Array, length: float
) -> Float64Array:
    """Which demonstrations are connected, by small steps, to the one with the nearest start."""
    gaps = np.sqrt(((shifted[:, None] - shifted[None]) ** 2).sum(axis=3).mean(axis=2))
    neighbours = gaps < _SAME_WAY * length
    chosen = np.zeros(len(shifted), dtype=bool)
    chosen[int(np.argmin(np.linalg.norm(starts - start, axis=1)))] = True
    for _ in shifted:
        chosen = chosen | neighbours[chosen].any(axis=0)
    return chosen


def _weights(starts: Float64Array, start: Float64Array, chosen: Float64Array) -> Float64Array:
    """Gaussian weights in the distance of the starts, as wide as these are spread; sum 1."""
    squared = ((starts - start) ** 2).sum(axis=1)
    spread = float(starts.var(axis=0, ddof=1).sum()) if len(starts) > 1 else 0.0
    nearer = np.zeros(len(starts))
    if spread > 0.0:
        nearer = -(squared - squared[chosen].min()) / (2.0 * spread)
    weights = np.where(chosen, np.exp(np.where(chosen, nearer, 0.0)), 0.0)
    return np.asarray(weights / weights.sum())
