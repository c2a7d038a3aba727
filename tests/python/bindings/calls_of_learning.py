"""Calls of what learns from demonstrations: alignment, Gaussians, basis functions."""

import numpy as np
from bindings.calls import call

from leadthrough import _core as core

X, Y = np.tile([1.0, 0.0, 0.0], (2, 1)), np.tile([0.0, 1.0, 0.0], (2, 1))

call(core.dtw_distance, 2.0, a=X, b=0 * X)
call(core.dtw_path, [[0, 0], [1, 1]], a=np.vstack([X[0], Y[0]]), b=np.vstack([X[0], Y[0]]))
call(core.frechet_distance, 1.0, a=X, b=0 * X)
CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
MOVED = np.array([3.0, 4.0])
call(core.rms_apart, 5.0 * (1 - np.eye(2)), curves=np.stack([CORNER, CORNER + MOVED]))
call(core.arc_lengths, [0.0, 1.0, 2.0], points=CORNER)
call(core.by_arc_length, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], points=CORNER, count=3)
call(core.all_finite, True, values=np.arange(3.0))
call(core.is_covariance, True, matrix=np.eye(2))
call(
    core.normalised_bells,
    [[0.5, 0.5]],
    phases=np.array([0.5]),
    centres=np.array([0.0, 1.0]),
    sharpness=2.0,
    periodic=False,
    order=0,
)
MOTIONS = {"weights": np.array([[2.0, 4.0, 1.0, 3.0]]), "most": 1, "threads": 1}  # two curves each
call(
    core.curves_over,
    [[[[[3.0, 2.0]], [[-2.0, -2.0]]]]],
    basis=np.array([[0.5, 0.5], [1.0, -1.0]]),
    bases=2,
    **MOTIONS,
)
call(
    core.curves_over_bells,
    [[[[[3.0, 2.0]]]]],
    phases=np.array([0.5]),
    centres=np.array([0.0, 1.0]),
    sharpness=2.0,
    periodic=False,
    factors=np.ones(1),
    **MOTIONS,
)
call(core.product, [[2.0, 3.0]], left=np.ones((1, 2)), right=np.array([[1.0, 1.0], [1.0, 2.0]]))
call(core.solve_definite, [[0.5], [2.0]], matrix=2.0 * np.eye(2), right=np.array([[1.0], [4.0]]))
call(
    core.bounced,
    [[0.0, 2.0]],
    walls=np.eye(2),
    limits=np.full(2, 5.0),
    start=np.ones(2),
    velocities=np.array([[0.0, 2.0]]),
)
call(
    core.condition_weights,
    False,
    mean=np.zeros(4),
    covariance=np.eye(4),
    basis=np.array([[1.0, 0.0]]),
    columns=np.array([0, 1]),
    values=np.ones((1, 2)),
    noise=np.zeros((2, 2)),
    scale=np.ones(2),
    least=1e-9,
)
call(
    core.condition_at,
    [0.5, 0.5],
    mean=np.zeros(2),
    covariance=np.eye(2),
    centres=np.array([0.0, 1.0]),
    sharpness=2.0,
    periodic=False,
    scale=np.ones(1),
    duration=2.0,
    time=1.0,
    position=np.array([1.0]),
    noise=np.array([[0.5]]),
    least=1e-9,
)
