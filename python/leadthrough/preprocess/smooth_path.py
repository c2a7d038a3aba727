"""Smooths paths that were computed on a grid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length, by_arc_length

_DEGREE = 3
_SAMPLES_PER_KNOT = 6
# Weight of both end points, so large that moving the end coefficients onto them changes nothing
# else.
_END_WEIGHT = 1e3
_HALVINGS = 4


def smooth_path(
    path: Float64Array,
    *,
    knot_spacing: float,
    accept: Callable[[Float64Array], bool] = lambda points: True,  # noqa: ARG005
) -> Float64Array:
    """Dense samples of a C2 curve close to a path, with the same end points."""
    length = arc_length(path)[-1]
    if length == 0.0:
        return path
    for halving in range(_HALVINGS + 1):
        pieces = int(np.ceil(length / knot_spacing)) * 2**halving
        candidate = _fit(path, max(pieces, 1))
        if accept(candidate):
            return candidate
    return path


def _fit(path: Float64Array, pieces: int) -> Float64Array:
    samples = by_arc_length(path, _SAMPLES_PER_KNOT * pieces + 1)
    phase = np.linspace(0.0, 1.0, len(samples))
    inner = np.linspace(0.0, 1.0, pieces + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
    weights = np.ones(len(samples))
    weights[[0, -1]] = _END_WEIGHT
    from scipy.interpolate import make_lsq_spline

    spline = make_lsq_spline(phase, samples, knots, k=_DEGREE, w=weights)
    spline.c[[0, -1]] = samples[[0, -1]]
    return np.asarray(spline(phase))
