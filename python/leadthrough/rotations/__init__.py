"""Rotations in batches: unit quaternions (w, x, y, z) and rotation vectors (axis times angle, rad).

Angular velocities are in the base frame: exp(omega dt), multiplied from the left, turns a rotation
further. q and -q are the same rotation everywhere.

Source: Sola, Deray and Atchuthan 2018, "A micro Lie theory for state estimation in robotics".
"""

from leadthrough.rotations.group import (
    align_signs,
    compose,
    distance,
    exp,
    from_euler,
    from_matrix,
    inverse,
    lift,
    log,
    mean,
    to_euler,
    to_matrix,
)
from leadthrough.rotations.interpolation import (
    angular_acceleration,
    angular_velocity,
    integrate,
    interpolate,
    left_jacobian,
    left_jacobian_inverse,
    slerp,
    squad,
)

__all__ = [
    "align_signs",
    "angular_acceleration",
    "angular_velocity",
    "compose",
    "distance",
    "exp",
    "from_euler",
    "from_matrix",
    "integrate",
    "interpolate",
    "inverse",
    "left_jacobian",
    "left_jacobian_inverse",
    "lift",
    "log",
    "mean",
    "slerp",
    "squad",
    "to_euler",
    "to_matrix",
]
