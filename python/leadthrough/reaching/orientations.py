"""Orientations spread evenly over all rotations.

Source: Alexa 2022, "Super-Fibonacci spirals: fast, low-discrepancy sampling of SO(3)", CVPR.
"""

from __future__ import annotations

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array

_PHI = np.sqrt(2.0)
_PSI = 1.533751168755204288118041  # root of x^4 = x + 4


def spread_orientations(count: int) -> Float64Array:
    """Quaternions (count, 4) w, x, y, z that are spread evenly over all rotations.

    Args:
        count: their number, >= 1.

    Raises:
        InvalidInput: if it is not a positive integer.
    """
    number = check.integer(count, "count", at_least=1)
    at = np.arange(number) + 0.5
    fraction = at / number
    near, far = np.sqrt(fraction), np.sqrt(1.0 - fraction)
    alpha, beta = 2.0 * np.pi * at / _PHI, 2.0 * np.pi * at / _PSI
    parts = (far * np.cos(beta), near * np.sin(alpha), near * np.cos(alpha), far * np.sin(beta))
    return np.column_stack(parts)
