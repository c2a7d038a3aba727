"""Stiffness along a motion, from how much its demonstrations vary.

Along axes in which demonstrations vary little, the task constrains the motion and the arm
should be stiff; where they vary much, it may be compliant.

Source: Calinon, Sardellitti and Caldwell 2010, "Learning-based control strategy for safe
human-robot interaction".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput

# No variance counts as less than this fraction of the largest; below zero by more than it, a
# covariance is refused.
_MIN_VARIANCE = 1e-9
# Logarithms of variances that span less than this are all the same.
_ALIKE = 1e-9


def stiffness_profile(covariances: ArrayLike, *, softest: float, stiffest: float) -> Float64Array:
    """Stiffness matrices along a motion, with the axes of its covariances.

    Along an axis, the stiffness is `stiffest` at the least standard deviation of the whole motion,
    `softest` at the largest, and geometrically interpolated in between.

    Args:
        covariances: covariances (n, d, d) along the motion; all columns in one unit.
        softest: least stiffness, N/m or N m/rad, > 0.
        stiffest: largest stiffness, in the same unit, >= softest.

    Returns:
        Symmetric matrices (n, d, d).

    Raises:
        InvalidInput: if the covariances are not symmetric and positive semi-definite, if all are
            zero or there is none, or if the stiffnesses are out of range.
    """
    given = check.array(covariances, "covariances", shape=("n", "d", "d"))
    least = check.number(softest, "softest", above=0.0)
    most = check.number(stiffest, "stiffest", at_least=least)
    if not np.allclose(given, given.transpose(0, 2, 1)) or len(given) == 0:
        raise InvalidInput("covariances: expected at least one matrix, all symmetric")
    variances, axes = np.linalg.eigh(given)
    largest = float(variances.max())
    if not largest > 0.0 or variances.min() < -_MIN_VARIANCE * largest:
        raise InvalidInput("covariances: expected positive semi-definite matrices, not all zero")
    spread = np.log(np.maximum(variances, _MIN_VARIANCE * largest))
    low, reach = spread.min(), np.ptp(spread)
    softness = (spread - low) / reach if reach > _ALIKE else np.zeros_like(spread)
    stiffness = most * (least / most) ** softness
    return np.asarray((axes * stiffness[:, None, :]) @ axes.transpose(0, 2, 1))
