"""Curves of rotations: slerp, piecewise slerp, squad, and angular velocity and acceleration.

Velocities and accelerations are those of the base frame.
"""

from __future__ import annotations

from itertools import combinations
from math import factorial

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.rotations.group import align_signs, pair, timed

# Nearer to a whole number of turns the inverse's entries pass ten million.
WHOLE_TURN_MARGIN = 1e-6  # rad


def slerp(a: ArrayLike, b: ArrayLike, fractions: ArrayLike) -> Float64Array:
    """Rotations (n, 4) on the shortest turns from a to b, at constant speed.

    Args:
        a: unit quaternions (n, 4).
        b: unit quaternions (n, 4). Of the two ways of exactly half a turn, the result takes the
            one to b with the sign as given.
        fractions: how far to turn, (n,), from 0 at a to 1 at b.

    Returns:
        Quaternions that are continuous from a, so that at 1 they may be -b.

    Source: Shoemake 1985, "Animating rotation with quaternion curves".
    """
    first, second = pair(a, b)
    parts = check.array(fractions, "fractions", shape=(len(first),))
    if ((parts < 0) | (parts > 1)).any():
        raise check.refused("fractions", "numbers from 0 to 1", f"{parts.min()} to {parts.max()}")
    return core.so3_slerp(first, second, parts)


def interpolate(times: ArrayLike, quaternions: ArrayLike, at: ArrayLike) -> Float64Array:
    """Rotations (m, 4) on the shortest turns between samples.

    They are continuous, signs too, with a jump of the angular velocity at every sample.

    Args:
        times: of the samples, s, (n,), n >= 2.
        quaternions: the samples, unit quaternions (n, 4).
        at: times of the result, s, (m,), not before the first sample or after the last.
    """
    t, samples = timed(times, quaternions, at_least=2)
    q = align_signs(samples)
    i, fractions = _places(t, at)
    return core.so3_slerp(q[i], q[i + 1], fractions)


def squad(times: ArrayLike, quaternions: ArrayLike, at: ArrayLike) -> Float64Array:
    """Rotations (m, 4) on a curve through samples with a continuous angular velocity.

    At the samples the velocity is that of `angular_velocity`. At evenly spaced times it is
    Shoemake's curve. A long step after a short and fast one starts with the velocity of the short
    one and swings far out: `interpolate` is safer there.

    Args:
        times: of the samples, s, (n,), n >= 2, evenly spaced or not.
        quaternions: the samples, unit quaternions (n, 4); any three neighbours turn less than half
            a turn.
        at: times of the result, s, (m,), not before the first sample or after the last.

    Raises:
        InvalidInput: if steps are too uneven.

    Source: Shoemake 1987, "Quaternion calculus and fast animation".
    """
    t, samples = timed(times, quaternions, at_least=2)
    q = align_signs(samples)
    i, fractions = _places(t, at)
    leaving, arriving = squad_controls(t, q)
    chord = core.so3_slerp(q[i], q[i + 1], fractions)
    handle = core.so3_slerp(leaving[i], arriving[i], fractions)
    return core.so3_slerp(chord, handle, 2.0 * fractions * (1.0 - fractions))


def squad_controls(times: Float64Array, q: Float64Array) -> tuple[Float64Array, Float64Array]:
    """The two inner rotations of every step between samples, which make `squad` smooth at them."""
    velocities = angular_velocity(times, q)
    turns = core.so3_log(core.so3_compose(q[1:], q[:-1] * [1.0, -1.0, -1.0, -1.0]))
    steps = np.diff(times)[:, None]
    with np.errstate(over="ignore"):  # infinite results are refused below
        outwards = core.so3_exp(0.5 * (steps * velocities[:-1] - turns))
        inwards = core.so3_exp(0.5 * (turns - steps * velocities[1:]))
    if not (np.isfinite(outwards).all() and np.isfinite(inwards).all()):
        raise InvalidInput("times: expected steps of similar length, got steps that are too uneven")
    return core.so3_compose(outwards, q[:-1]), core.so3_compose(inwards, q[1:])


def _places(times: Float64Array, at: ArrayLike) -> tuple[NDArray[np.intp], Float64Array]:
    """The interval that each time lies in, and the fraction of it that has passed."""
    asked = check.array(at, "at", shape=("m",))
    outside = (asked < times[0]) | (asked > times[-1])
    if outside.any():
        raise InvalidInput(
            f"at: expected times from {times[0]} s to {times[-1]} s, got {asked[outside][0]} s"
        )
    i = np.clip(np.searchsorted(times, asked, side="right") - 1, 0, len(times) - 2)
    return i, (asked - times[i]) / (times[i + 1] - times[i])


def left_jacobian(rotation_vectors: ArrayLike) -> Float64Array:
    """Matrices (n, 3, 3) that turn derivatives of rotation vectors into angular velocities.

    omega = J d(phi)/dt for the rotation exp(phi); singular at 2 pi n, n >= 1.

    Args:
        rotation_vectors: phi, rad, (n, 3).

    Source: Sola et al. 2018, eq. 145.
    """
    vectors = check.array(rotation_vectors, "rotation_vectors", shape=("n", 3))
    return np.asarray(core.so3_left_jacobian(vectors).reshape(-1, 3, 3))


def left_jacobian_inverse(rotation_vectors: ArrayLike) -> Float64Array:
    """Inverses (n, 3, 3) of `left_jacobian`: d(phi)/dt = J^-1 omega.

    Args:
        rotation_vectors: phi, rad, (n, 3).

    Raises:
        InvalidInput: if one is within 1e-6 rad of 2 pi n, n >= 1, where there is no inverse.

    Source: Sola et al. 2018, eq. 146.
    """
    vectors = check.array(rotation_vectors, "rotation_vectors", shape=("n", 3))
    sines = np.linalg.norm(core.so3_exp(vectors)[:, 1:], axis=1)
    singular = (2.0 * sines < WHOLE_TURN_MARGIN) & (np.abs(vectors).max(axis=1, initial=0.0) > 1.0)
    if singular.any():
        i = int(np.argmax(singular))
        raise InvalidInput(
            "rotation_vectors: expected none that is a whole number of turns long, "
            f"got {vectors[i]} at row {i}"
        )
    return np.asarray(core.so3_left_jacobian_inverse(vectors).reshape(-1, 3, 3))


def angular_velocity(times: ArrayLike, quaternions: ArrayLike) -> Float64Array:
    """Angular velocities (n, 3), rad/s, base frame, of rotations at given times.

    Second order in the steps, which may be uneven, and at the ends too.

    Args:
        times: s, (n,), n >= 2.
        quaternions: unit quaternions (n, 4); any three neighbours turn less than half a turn.

    Raises:
        InvalidInput: if neighbours turn too far, or steps are too short for finite derivatives.
    """
    return _derivative(*timed(times, quaternions, at_least=2), order=1)


def angular_acceleration(times: ArrayLike, quaternions: ArrayLike) -> Float64Array:
    """Angular accelerations (n, 3), rad/s^2, base frame, of rotations at given times.

    As `angular_velocity`, for n >= 3 and any four neighbours that turn less than half a turn.
    """
    return _derivative(*timed(times, quaternions, at_least=3), order=2)


def integrate(times: ArrayLike, angular_velocities: ArrayLike, start: ArrayLike) -> Float64Array:
    """Rotations (n, 4) that turn from a start with given angular velocities.

    q_(k+1) = exp(omega dt) q_k with omega the mean of the velocities at both ends of the step;
    second order.

    Args:
        times: s, (n,).
        angular_velocities: rad/s in the base frame, (n, 3).
        start: unit quaternion (4,) at the first time.
    """
    t = check.times(times, "times")
    velocities = check.array(angular_velocities, "angular_velocities", shape=(len(t), 3))
    first = check.quaternions(start, "start", shape=(4,))
    result = core.so3_integrate(t, velocities, first)
    if not np.isfinite(result).all():
        raise InvalidInput("angular_velocities: expected turns of finite size, got infinite ones")
    return result


def _derivative(times: Float64Array, quaternions: Float64Array, *, order: int) -> Float64Array:
    """Derivative of the rotation vectors from each sample to its neighbours."""
    # At the sample itself that vector is 0 and J = 1, dJ/dt phi' = 0: these are the body's rates.
    count = len(times)
    width = min(order + 2, count)
    first = np.clip(np.arange(count) - 1, 0, count - width)
    rows = first[:, None] + np.arange(width)
    _check_turns(quaternions, first, width)
    back = np.repeat(quaternions * [1.0, -1.0, -1.0, -1.0], width, axis=0)
    vectors = core.so3_log(core.so3_compose(quaternions[rows].reshape(-1, 4), back))
    with np.errstate(all="ignore"):  # a result that is not finite is refused below
        weights = _weights_at_zero(times[rows] - times[:, None], order)
        result = np.einsum("nw,nwi->ni", weights, vectors.reshape(count, width, 3))
    if not np.isfinite(result).all():
        raise InvalidInput("times: expected longer steps; the derivatives are not finite")
    return np.asarray(result)


def _check_turns(quaternions: Float64Array, first: NDArray[np.intp], width: int) -> None:
    steps = core.so3_distance(quaternions[:-1], quaternions[1:])
    turns = np.sum([steps[first + i] for i in range(width - 1)], axis=0)
    if (turns >= np.pi).any():
        i = int(np.argmax(turns >= np.pi))
        raise InvalidInput(
            f"quaternions: expected less than half a turn from sample {first[i]} to "
            f"{first[i] + width - 1}, got {np.degrees(turns[i]):.4g} degrees"
        )


def _weights_at_zero(nodes: Float64Array, order: int) -> Float64Array:
    """Weights (n, w) of values at nodes (n, w) in their Lagrange polynomial's derivative at 0."""
    width = nodes.shape[1]
    weights = np.empty_like(nodes)
    for j in range(width):
        others = np.delete(nodes, j, axis=1)
        factors = [
            np.prod(-others[:, list(chosen)], axis=1)
            for chosen in combinations(range(width - 1), width - 1 - order)
        ]
        weights[:, j] = np.sum(factors, axis=0) / np.prod(nodes[:, [j]] - others, axis=1)
    return factorial(order) * weights
