"""Configurations, one or a batch of them, as rows for the kernels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput


def joint_rows(chain: _core.Chain, **values: ArrayLike) -> tuple[bool, list[Float64Array]]:
    """Whether the values are batches, and each as checked rows (m, joints)."""
    shapes: Sequence[tuple[int | str, ...]] = ((chain.joints,), ("m", chain.joints))
    rows = []
    for name, value in values.items():
        rows.append(check.array_of_rank(value, name, shapes=shapes))
        shapes = (rows[0].shape,)
    if rows[0].ndim == 2:
        return True, rows
    return False, [row[None] for row in rows]


def finite(result: Float64Array) -> Float64Array:
    """`result`, if it is finite."""
    if not np.isfinite(result).all():
        raise InvalidInput(
            "q, qd or qdd: the values are too large, the result overflows; use rad, rad/s and "
            "rad/s^2 (m for prismatic joints)"
        )
    return result
