"""Curves sampled by arc length instead of by time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_ENDLESS = "points: expected a curve of finite length; use a larger unit"


def arc_length(points: ArrayLike) -> Float64Array:
    """Lengths (n,) of the polygonal line through points, from the first one to each, from 0 on."""
    lengths = _core.arc_lengths(_curve(points))
    if not np.isfinite(lengths[-1]):
        raise InvalidInput(_ENDLESS)
    return lengths


def by_arc_length(points: ArrayLike, count: int) -> Float64Array:
    """Points (count, d), evenly spaced in arc length along the polygonal line through others."""
    curve = _curve(points)
    even = _core.by_arc_length(curve, check.integer(count, "count", at_least=2))
    if even is None:
        raise InvalidInput(_ENDLESS)
    return even


def _curve(points: ArrayLike) -> Float64Array:
    """At least one point (n, d)."""
    curve = check.array(points, "points", shape=("n", "d"))
    if len(curve) == 0:
        raise InvalidInput("points: expected at least one point, got none")
    if curve.shape[1] == 0:
        raise InvalidInput("points: expected at least one coordinate, got points without any")
    return curve
