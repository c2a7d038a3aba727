"""A smooth path through the samples of a joint trajectory, within a tolerance.

Splines of degree five are fitted by least squares with as few knots as the tolerance allows: spans
that miss it are halved. The parameter of the path is the samples' time, but it does not grow while
they stand still.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.trajectories import Spline

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_DEGREE = 5
_FIRST_SPANS = 4
# A span needs a few more samples than coefficients of its own, or it swings between them.
_LEAST_SAMPLES = 3
# Each end weighs as much as this many samples: it is met as if it were interpolated.
_WEIGHT_OF_ENDS = 1e4


def moving_samples(
    times: Float64Array, q: Float64Array, tolerance: float
) -> tuple[NDArray[np.intp], Float64Array]:
    """The samples that differ from the one kept before by more than the tolerance.

    Args:
        times: s, (n,).
        q: samples (n, joints).
        tolerance: rad (m), the largest difference of a joint that counts as standing still.

    Returns:
        Their indices (m,), the last sample always among them, and their parameters (m,).
    """
    kept = [0]
    for i in range(1, len(q)):
        if np.abs(q[i] - q[kept[-1]]).max() > tolerance:
            kept.append(i)
    if kept[-1] != len(q) - 1:  # which lies within the tolerance of the last one kept
        kept = [*kept[: max(len(kept) - 1, 1)], len(q) - 1]
    indices = np.array(kept, dtype=np.intp)
    steps = np.diff(times[indices])
    usual = float(np.median(np.diff(times)))
    return indices, np.concatenate([[0.0], np.cumsum(np.minimum(steps, usual))])


def fit_within(parameters: Float64Array, q: Float64Array, tolerance: float) -> Spline:
    """A spline with two continuous derivatives or more, within the tolerance of every sample.

    Args:
        parameters: strictly increasing, (n,).
        q: samples (n, d).
        tolerance: the largest error of a coordinate.
    """
    from scipy.interpolate import make_lsq_spline

    count = len(parameters)
    if count <= _DEGREE + 1:
        return through(parameters, q)
    breaks = np.unique(np.linspace(0, count - 1, _FIRST_SPANS + 1).astype(int))
    weights = np.ones(count)
    weights[[0, -1]] = _WEIGHT_OF_ENDS
    while np.diff(breaks).min() >= _LEAST_SAMPLES:
        inner = parameters[breaks[1:-1]]
        ends = parameters[[0, -1]]
        knots = np.concatenate([ends[[0] * (_DEGREE + 1)], inner, ends[[1] * (_DEGREE + 1)]])
        fit = make_lsq_spline(parameters, q, knots, k=_DEGREE, w=weights)
        missed = np.abs(fit(parameters) - q).max(axis=1) > tolerance
        if not missed.any():
            return _pieces(fit, parameters[breaks])
        spans = np.unique(np.searchsorted(breaks, np.flatnonzero(missed), side="right") - 1)
        spans = np.minimum(spans, len(breaks) - 2)
        middles = (breaks[spans] + breaks[spans + 1]) // 2
        breaks = np.unique(np.concatenate([breaks, middles]))
    return through(parameters, q)


def through(parameters: Float64Array, q: Float64Array) -> Spline:
    """The cubic spline through all samples; its third derivative is continuous near its ends."""
    from scipy.interpolate import CubicSpline

    ends = "not-a-knot" if len(q) > 2 else "natural"
    spline = CubicSpline(parameters, q, bc_type=ends)
    return Spline(spline.x, spline.c[::-1].transpose(1, 0, 2))


def _pieces(fit: BSpline, breaks: Float64Array) -> Spline:
    derivatives = [fit(breaks[:-1], nu=k) / math.factorial(k) for k in range(_DEGREE + 1)]
    return Spline(breaks, np.stack(derivatives, axis=1))
