"""Rotations in batches: unit quaternions (w, x, y, z) and rotation vectors (axis times angle, rad).

Angular velocities are those of the base frame: exp(omega dt) turns a rotation on, from the left.
q and -q are the same rotation everywhere.
Source: Sola, Deray and Atchuthan 2018, "A micro Lie theory for state estimation in robotics".
"""

from leadthrough.rotations.averaging import mean
from leadthrough.rotations.group import align_signs, compose, distance, exp, inverse, log
from leadthrough.rotations.interpolation import slerp
from leadthrough.rotations.matrices import to_matrix

__all__ = [
    "align_signs",
    "compose",
    "distance",
    "exp",
    "inverse",
    "log",
    "mean",
    "slerp",
    "to_matrix",
]
