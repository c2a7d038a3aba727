"""Distances between two curves whose points are paired in order, whatever their timing."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput


def dtw_distance(a: ArrayLike, b: ArrayLike) -> float:
    """The dynamic time warping distance: the smallest sum of distances over paired points.

    Args:
        a: points (n, d) of the first curve.
        b: points (m, d) of the second curve.

    Returns:
        The sum, in the curves' unit.

    Source: Sakoe and Chiba 1978, with symmetric steps of weight one.
    """
    return _finite(core.dtw_distance(*_curves(a, b)))


def frechet_distance(a: ArrayLike, b: ArrayLike) -> float:
    """The discrete Frechet distance: the smallest possible largest distance of paired points.

    Args:
        a: points (n, d) of the first curve.
        b: points (m, d) of the second curve.

    Returns:
        The distance, in the curves' unit.

    Source: Eiter and Mannila 1994.
    """
    return _finite(core.frechet_distance(*_curves(a, b)))


def _curves(a: ArrayLike, b: ArrayLike) -> tuple[Float64Array, Float64Array]:
    first = check.array(a, "a", shape=("n", "d"))
    second = check.array(b, "b", shape=("m", first.shape[1]))
    for curve, name in ((first, "a"), (second, "b")):
        if curve.size == 0:
            raise InvalidInput(f"{name}: expected at least one point, got shape {curve.shape}")
    return first, second


def _finite(value: float) -> float:
    if not np.isfinite(value):
        raise InvalidInput("curves: expected coordinates whose squares are finite, got larger ones")
    return value
