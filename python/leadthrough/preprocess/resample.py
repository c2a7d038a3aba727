"""Curves sampled by arc length instead of by time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput


def arc_length(points: ArrayLike) -> Float64Array:
    """Lengths (n,) of the polygonal line through points, from the first one to each, from 0 on.

    Args:
        points: (n, d), at least one.

    Raises:
        InvalidInput: if there is none, one is not finite, or the length overflows.
    """
    curve = check.array(points, "points", shape=("n", "d"))
    if len(curve) == 0:
        raise InvalidInput("points: expected at least one point, got none")
    with np.errstate(over="ignore"):
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    if not np.isfinite(lengths[-1]):
        raise InvalidInput("points: expected a curve of finite length; use a larger unit")
    return lengths


def by_arc_length(points: ArrayLike, count: int) -> Float64Array:
    """Points (count, d), evenly spaced in arc length along the polygonal line through others.

    The ends stay; pauses and repeated points do not matter.

    Args:
        points: (n, d), at least one.
        count: at least 2.

    Raises:
        InvalidInput: as by `arc_length`, or if the count is too small.
    """
    lengths = arc_length(points)
    size = check.integer(count, "count", at_least=2)
    # A step that adds no length has no inside to interpolate in.
    distinct = np.concatenate([[True], np.diff(lengths) > 0])
    curve = check.array(points, "points", shape=("n", "d"))[distinct]
    at = lengths[distinct]
    if len(curve) == 1:
        return np.repeat(curve, size, axis=0)
    wanted = np.linspace(0.0, at[-1], size)
    left = np.clip(np.searchsorted(at, wanted, side="right") - 1, 0, len(at) - 2)
    part = ((wanted - at[left]) / (at[left + 1] - at[left]))[:, None]
    return np.asarray((1.0 - part) * curve[left] + part * curve[left + 1])
