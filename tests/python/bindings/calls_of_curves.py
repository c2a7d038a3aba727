"""Calls of what evaluates and makes curves."""

import numpy as np
from bindings.calls import ONE, QUARTER, call

from leadthrough import _core as core

call(
    core.so3_slerp_through,
    [ONE[0], QUARTER[0]],
    times=np.array([0.0, 1.0]),
    quaternions=np.vstack([ONE[0], QUARTER[0]]),
    at=np.array([0.0, 1.0]),
)
call(
    core.polynomial_values,
    [[3.0], [5.0]],
    knots=np.array([0.0, 1.0]),
    coefficients=np.array([[1.0], [1.0], [1.0]]),
    times=np.array([1.0, 2.0]),
    order=1,
)
call(
    core.bezier_values,
    [[0.5, 1.0]],
    points=np.array([[0.0, 2.0], [1.0, 0.0]]),
    fractions=np.array([0.5]),
)
call(
    core.cubic_through,
    [[0.0], [1.0], [0.0], [0.0]],
    parameters=np.array([0.0, 2.0]),
    q=np.array([[0.0], [2.0]]),
)
