"""What tracking error a controller's gains allow: the linear answer to what it does not know.

Near the motion, the error e = q_planned - q of an arm with the mass matrix M obeys

    M e'' + D e' + K e = u

with the stiffness K and damping D of the controller, and u the torques that the motion needs and
the controller does not feed forward: friction, its own approximations, pushes, and what a delayed
measurement adds. It is solved here sample by sample, as the controller works.
"""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.simulation.controllers import Motion
from leadthrough.simulation.simulated_arm import Push, SimulatedArm

_EVERY = 10  # samples that share a mass matrix and gains
# The model is linear: products of errors are not in it, by which joints disturb each other too.
_SLACK, _COUPLED = 1.3, 0.1
_CURVED = 2.0  # 1/rad (1/m)
_LEAST = 2e-4  # rad (m)
_ENCODER_STEPS = 2.0  # that noise of the encoders may move a joint by
_MOVING = 1e-6  # rad/s (m/s): slower, dry friction is that of the last way
_DIVERGED = 1e3  # rad (m)


def expected_errors(
    real: SimulatedArm,
    q: Float64Array,
    qd: Float64Array,
    qdd: Float64Array,
    progress: Float64Array,
    *,
    pushes: tuple[Push, ...],
    late: int,
) -> tuple[Float64Array, Float64Array]:
    """Tracking errors that the linear model gives, and the part of them that is by dry friction."""
    law, plant = real.law, real.plant
    left = plant.damping * qd + _pushed(real, q, pushes)
    torques = law.arm.inverse_dynamics(q, qd, qdd, gravity=law.gravity)
    weight = law.arm.gravity_torques(q, gravity=law.gravity)
    coarse = slice(None, None, _EVERY)
    mass = law.arm.mass_matrix(q[coarse])
    gains = law.gains(Motion(q[coarse], mass, torques[coarse], weight[coarse], progress[coarse]))
    # Dampers in the joints and their drives act at once, and at the end of a period.
    dampers = plant.damping + law.drive_damping
    ease = np.asarray(np.linalg.inv(mass + real.period * np.diag(dampers)))
    answer = np.concatenate([ease @ gains.stiffness, ease @ gains.damping], axis=2)
    left += _between(gains.unmodelled, len(q))
    eased = _repeated(ease, len(q))
    pull = _products(eased, left)
    if late:
        before = np.maximum(np.arange(len(q)) - late, 0)
        moved = np.concatenate([q - q[before], qd - qd[before]], axis=1)
        pull -= _products(_repeated(answer, len(q)), moved)
    smooth = _integrated(answer, ease * dampers, pull, real.period, late=late)
    if not plant.friction.any():
        return smooth, np.zeros_like(smooth)
    pull = _products(eased, plant.friction * _directions(qd))
    dry = _integrated(answer, ease * dampers, pull, real.period, late=late)
    return smooth + dry, dry


def allowed_errors(expected: Float64Array, dry: Float64Array, *, encoder: float) -> Float64Array:
    """The largest error (joints,) that the gains allow."""
    if not np.isfinite(expected).all():
        return np.full(expected.shape[1], np.inf)
    most = np.abs(expected - dry).max(axis=0) + np.abs(dry).max(axis=0)
    largest = float(most.max())
    second_order = (_COUPLED + _CURVED * largest) * largest
    return np.asarray(_SLACK * most + second_order + _LEAST + _ENCODER_STEPS * encoder)


def _integrated(
    answer: Float64Array, slowing: Float64Array, pull: Float64Array, period: float, *, late: int
) -> Float64Array:
    count, joints = pull.shape
    states = np.zeros((count + 1, 2 * joints))
    now = states[0]
    for k in range(count):
        i, seen = k // _EVERY, states[max(k - late, 0)]
        change = pull[k] - answer[i] @ seen - slowing[i] @ now[joints:]
        speed = now[joints:] + period * change
        now = states[k + 1]
        now[joints:] = speed
        now[:joints] = states[k, :joints] + period * speed
        if k % _EVERY == 0 and not np.abs(now).max() < _DIVERGED:
            return np.full((count, joints), np.inf)
    return np.asarray(states[:count, :joints])


def _directions(qd: Float64Array) -> Float64Array:
    """Signs (n, joints) of the velocities; at rest those of the movement before."""
    signs = np.where(np.abs(qd) > _MOVING, np.sign(qd), 0.0)
    last = np.maximum.accumulate(np.where(signs != 0.0, np.arange(len(qd))[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(signs, last, axis=0))


def _pushed(real: SimulatedArm, q: Float64Array, pushes: tuple[Push, ...]) -> Float64Array:
    """Torques (n, joints) against the pushes."""
    result = np.zeros_like(q)
    times = real.period * np.arange(len(q))
    for push in pushes:
        during = (times >= push.time) & (times < push.time + push.duration)
        if during.any():
            jacobian = real.arm.jacobian(q[during])[:, :3]
            result[during] -= np.asarray(push.force) @ jacobian
    return result


def _products(matrices: Float64Array, vectors: Float64Array) -> Float64Array:
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])


def _repeated(coarse: Float64Array, count: int) -> Float64Array:
    return np.repeat(coarse, _EVERY, axis=0)[:count]


def _between(coarse: Float64Array, count: int) -> Float64Array:
    """Rows for all samples, from those of every tenth."""
    at, known = np.arange(count), np.arange(len(coarse)) * _EVERY
    return np.column_stack([np.interp(at, known, column) for column in coarse.T])
