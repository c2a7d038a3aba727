"""Weight distributions of ProMPs from demonstrations by regularised least squares.

A curve is fitted to each demonstration. The covariance of their weights is shrunk towards a prior,
with the strength that minimises the expected squared error, so that it has full rank with fewer
demonstrations than weights, even with one.

Source: Schaefer and Strimmer 2005, "A shrinkage approach to large-scale covariance matrix
estimation", eq. 8.
"""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.dense import product, solve_definite
from leadthrough.models.promp.estimation import LEAST_SPREAD, Fit, Shown
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.prior import raised, shaped_prior, smooth_prior

# One demonstration says nothing about the spread of others: a tenth of its reach is assumed.
_UNKNOWN_SPREAD = 0.1
# The prior counts as at least this many demonstrations: the estimate knows nothing of it where two
# demonstrations deviate from their mean in opposite ways, as any two do.
_LEAST_SHRINKAGE = 0.5
_LEAST_NOISE = 1e-6  # standard deviation as a fraction of the reach


def least_squares(basis: Basis, shown: Shown, regularization: float) -> Fit:
    """The distribution of the weights of curves fitted to each motion."""
    curves, residuals = [], []
    known: dict[bytes, CurveFit] = {}
    for at, values in zip(shown.phases, shown.columns, strict=True):
        key = at.tobytes()
        if key not in known:
            known[key] = CurveFit(basis, at, regularization)
        fit = known[key]
        curves.append(fit.weights(values))
        residuals.append(((values - product(fit.values, curves[-1])) ** 2).sum(axis=0))
    samples = sum(len(at) for at in shown.phases)
    free = max(samples - len(curves) * basis.count, 1)
    noise = np.sum(residuals, axis=0) / free + (_LEAST_NOISE * shown.scale) ** 2
    stacked = np.stack([curve.T.ravel() for curve in curves])
    return Fit(shrunk(stacked, basis, shown.scale), noise, stacked)


class CurveFit:
    """Least-squares curves through values at the same phases, exact at both ends."""

    def __init__(self, basis: Basis, phases: Float64Array, regularization: float) -> None:
        self.values = basis(phases)
        normal = product(self.values.T, self.values)
        unit = float(np.trace(normal)) / basis.count
        normal += regularization * unit * basis.roughness
        normal[np.diag_indices(basis.count)] += 1e-12 * unit
        self._solved = solve_definite(normal, self.values.T)
        ends = [0] if basis.is_rhythmic else [0, -1]
        self._ends = ends
        influence = solve_definite(normal, self.values[ends].T)
        self._to_ends = product(influence, np.linalg.pinv(self.values[ends] @ influence))

    def weights(self, values: Float64Array) -> Float64Array:
        """The weights (k, d) of curves through values."""
        middle = values.mean(axis=0)  # adds to all weights alike, as the functions sum to one
        free = product(self._solved, values - middle)
        missed = values[self._ends] - middle - self.values[self._ends] @ free
        return np.asarray(free + product(self._to_ends, missed) + middle)


def shrunk(stacked: Float64Array, basis: Basis, scale: Float64Array) -> Gaussian:
    """Mean and shrunk covariance of weight vectors."""
    count = len(stacked)
    mean = stacked.mean(axis=0)
    if count == 1:
        return Gaussian(mean, smooth_prior(basis, _UNKNOWN_SPREAD * scale))
    unit = np.repeat(scale, basis.count)  # makes the result independent of the columns' units
    centred = (stacked - mean) / unit
    sample = product(centred.T, centred) / (count - 1)
    target = shaped_prior(basis, centred.reshape(count, len(scale), basis.count))
    distance = float(((sample - target) ** 2).sum())
    shrinkage = _LEAST_SHRINKAGE / count
    if distance > 0.0:
        shrinkage = max(shrinkage, min(_variance_of_sample(centred) / distance, 1.0))
    covariance = (1.0 - shrinkage) * sample + shrinkage * target
    covariance = raised(covariance, basis, LEAST_SPREAD)
    return Gaussian(mean, covariance * unit * unit[:, None])


def _variance_of_sample(centred: Float64Array) -> float:
    """Estimated expected squared error of the sample covariance of rows (m, p)."""
    count = len(centred)
    gram = product(centred, centred.T)
    fourth = float((np.diag(gram) ** 2).sum())
    total = fourth - float((gram**2).sum()) / count
    return count / (count - 1) ** 3 * total
