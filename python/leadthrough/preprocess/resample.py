"""Curves by arc length instead of by time."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput


def arc_length(points: Any) -> Float64Array:
    """Length (n,) of the polygon through points (n, d) up to each of them, from 0.

    n: at least 1. Raises InvalidInput.
    """
    curve = check.array(points, "points", shape=("n", "d"))
    if len(curve) == 0:
        raise InvalidInput("points: expected at least one, got none")
    with np.errstate(over="ignore"):
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    if not np.isfinite(lengths[-1]):
        raise InvalidInput("points: expected a curve of finite length, got an endless one")
    return lengths


def by_arc_length(points: Any, count: int) -> Float64Array:
    """`count` points (count, d), equally spaced in length along the polygon through points (n, d).

    The ends stay; pauses and repeated points do not matter. count: at least 2.
    Raises InvalidInput.
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
