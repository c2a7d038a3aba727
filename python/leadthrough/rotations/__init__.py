"""Rotations in batches: unit quaternions (w, x, y, z) and rotation vectors (axis times angle, rad).

Angular velocities are in the base frame: exp(omega dt), multiplied from the left, turns a rotation
further. q and -q are the same rotation everywhere.

Source: Sola, Deray and Atchuthan 2018, "A micro Lie theory for state estimation in robotics".
"""

from leadthrough.rotations.group import (
    align_signs as align_signs,
    angular_acceleration as angular_acceleration,
    angular_velocity as angular_velocity,
    compose as compose,
    distance as distance,
    exp as exp,
    from_euler as from_euler,
    from_matrix as from_matrix,
    integrate as integrate,
    interpolate as interpolate,
    inverse as inverse,
    left_jacobian as left_jacobian,
    left_jacobian_inverse as left_jacobian_inverse,
    lift as lift,
    log as log,
    mean as mean,
    slerp as slerp,
    squad as squad,
    to_euler as to_euler,
    to_matrix as to_matrix,
)
