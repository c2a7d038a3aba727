"""A smooth path through the samples of a joint trajectory, within a tolerance.

Splines of degree five are fitted by least squares with as few knots as the tolerance allows: spans
that miss it are halved. The parameter of the path is the samples' time, but it does not grow while
they stand still.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.trajectories import Spline

_DEGREE = 5


def moving_samples(
    times: Float64Array, q: Float64Array, tolerance: float
) -> tuple[NDArray[np.intp], Float64Array]:
    """The samples that differ from the one kept before by more than the tolerance."""
    indices = _core.rows_apart(np.ascontiguousarray(q), tolerance)
    if indices[-1] != len(q) - 1:  # which lies within the tolerance of the last one kept
        indices = np.append(indices[: max(len(indices) - 1, 1)], len(q) - 1)
    steps = np.diff(times[indices])
    usual = float(np.median(np.diff(times)))
    return indices, np.concatenate([[0.0], np.cumsum(np.minimum(steps, usual))])


def fit_within(parameters: Float64Array, q: Float64Array, tolerance: float) -> Spline:
    """A spline with two continuous derivatives or more, within the tolerance of every sample."""
    if len(parameters) <= _DEGREE + 1:
        return through(parameters, q)
    parameters, q = np.ascontiguousarray(parameters), np.ascontiguousarray(q)
    breaks, table = _core.fit_spline(parameters, q, tolerance)
    if len(breaks) == 0:
        return through(parameters, q)
    return Spline(parameters[breaks], table.reshape(len(breaks) - 1, _DEGREE + 1, q.shape[1]))


def through(parameters: Float64Array, q: Float64Array) -> Spline:
    """The cubic spline through all samples; its third derivative is continuous near its ends."""
    parameters, q = np.ascontiguousarray(parameters), np.ascontiguousarray(q)
    table = _core.cubic_through(parameters, q)
    return Spline(parameters, table.reshape(len(q) - 1, 4, q.shape[1]))
