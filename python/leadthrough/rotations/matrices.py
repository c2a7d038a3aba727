"""Rotation matrices."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array


def to_matrix(quaternions: Any) -> Float64Array:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4). Raises InvalidInput."""
    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    return np.asarray(_core.so3_to_matrix(q).reshape(-1, 3, 3))
