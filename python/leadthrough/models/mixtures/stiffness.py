"""How stiff an arm should be where: as stiff as its demonstrations were alike.

Where and along which axes demonstrations vary little, the motion is bound by the task; where they
vary, it may give way. Source: Calinon, Sardellitti and Caldwell 2010, "Learning-based control
strategy for safe human-robot interaction".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Spreads within this ratio of each other say nothing.
_ALIKE = 1e-9


def stiffness_profile(covariances: Any, *, softest: float, stiffest: float) -> Float64Array:
    """Stiffness matrices (n, d, d), symmetric, along a motion with covariances (n, d, d).

    Along the axes of each covariance: `stiffest` at the least standard deviation of the motion,
    `softest` at the largest, both > 0, N/m or N m/rad; in between a power of it. The columns must
    be of one unit. Raises InvalidInput.
    """
    given = check.array(covariances, "covariances", shape=("n", "d", "d"))
    least = check.number(softest, "softest", above=0.0)
    most = check.number(stiffest, "stiffest", at_least=least)
    if not np.allclose(given, given.transpose(0, 2, 1)) or len(given) == 0:
        raise InvalidInput("covariances: expected symmetric matrices, at least one")
    variances, axes = np.linalg.eigh(given)
    largest = float(variances.max())
    if not largest > 0.0 or variances.min() < -_ALIKE * largest:
        raise InvalidInput("covariances: expected positive semi-definite matrices, not all zero")
    spread = np.log(np.maximum(variances, _ALIKE * largest))
    low, reach = spread.min(), np.ptp(spread)
    share = (spread - low) / reach if reach > _ALIKE else np.zeros_like(spread)
    stiffness = most * (least / most) ** share
    return np.asarray((axes * stiffness[:, None, :]) @ axes.transpose(0, 2, 1))
