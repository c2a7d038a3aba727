"""The group of rotations: exponential, logarithm, product, inverse, distance, continuous logarithm
and mean; rotation matrices, and Euler angles in all twelve conventions; slerp, piecewise slerp,
squad, and angular velocity and acceleration in the base frame."""

from __future__ import annotations

from itertools import combinations
from math import factorial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoContinuousLogarithm

# A recording's rounding takes a matrix this far off; beyond, it is not a rotation.
ROTATION_TOLERANCE = 1e-2

# Newton's iteration squares the error: 1e-2, 1e-4, 1e-8, below rounding.
NEWTON_STEPS = 3
_INTRINSIC = tuple(a + b + c for a in "XYZ" for b in "XYZ" for c in "XYZ" if b not in (a, c))
CONVENTIONS = (*_INTRINSIC, *(convention.lower() for convention in _INTRINSIC))
# Within a quarter turn of one point there is only one mean (Afsari 2011); two rotations half a turn
# apart have two. With the margin, rounding does not decide between them.
MAX_REACH = np.pi / 2 - 1e-6  # rad


def exp(rotation_vectors: ArrayLike) -> Float64Array:
    """Unit quaternions (n, 4) of rotation vectors.

    Args:
        rotation_vectors: axis times angle, rad, (n, 3), of any length.
    """
    return core.so3_exp(check.array(rotation_vectors, "rotation_vectors", shape=("n", 3)))


def log(quaternions: ArrayLike) -> Float64Array:
    """Rotation vectors (n, 3), rad, of length at most pi.

    Args:
        quaternions: unit quaternions (n, 4). q and -q have the same logarithm, except at exactly
            pi, where the sign of the vector is q's.
    """
    return core.so3_log(check.quaternions(quaternions, "quaternions", shape=("n", 4)))


def compose(a: ArrayLike, b: ArrayLike) -> Float64Array:
    """Quaternions (n, 4) of the rotations that turn by b first, then by a."""
    return core.so3_compose(*pair(a, b))


def inverse(quaternions: ArrayLike) -> Float64Array:
    """Quaternions (n, 4) of the opposite rotations."""
    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    return np.asarray(q * [1.0, -1.0, -1.0, -1.0])


def distance(a: ArrayLike, b: ArrayLike) -> Float64Array:
    """Geodesic distances (n,) between rotations, from 0 to pi rad, whatever the signs."""
    return core.so3_distance(*pair(a, b))


def align_signs(quaternions: ArrayLike) -> Float64Array:
    """The same rotations (n, 4) with signs chosen so that neighbours lie in one hemisphere.

    Args:
        quaternions: unit quaternions (n, 4), of which the first keeps its sign.
    """
    return aligned(check.quaternions(quaternions, "quaternions", shape=("n", 4)))


def aligned(q: Float64Array) -> Float64Array:
    """`align_signs` of quaternions (n, 4) that have been checked already."""
    flips = np.einsum("ij,ij->i", q[1:], q[:-1]) < 0
    signs = np.concatenate([np.ones(min(len(q), 1)), np.where(np.cumsum(flips) % 2, -1.0, 1.0)])
    return np.asarray(q * signs[:, None])


def pair(a: ArrayLike, b: ArrayLike) -> tuple[Float64Array, Float64Array]:
    """Both arguments as unit quaternions (n, 4), as many in one as in the other."""
    first = check.quaternions(a, "a", shape=("n", 4))
    second = check.quaternions(b, "b", shape=("n", 4))
    if first.shape != second.shape:
        raise InvalidInput(f"b: expected as many rotations as a, {len(first)}, got {len(second)}")
    return first, second


def timed(
    times: ArrayLike, quaternions: ArrayLike, *, at_least: int
) -> tuple[Float64Array, Float64Array]:
    """Times (n,), s, and as many unit quaternions (n, 4), n >= at_least."""
    t = check.times(times, "times")
    if len(t) < at_least:
        raise InvalidInput(f"times: expected at least {at_least} samples, got {len(t)}")
    return t, check.quaternions(quaternions, "quaternions", shape=(len(t), 4))


def lift(quaternions: ArrayLike, *, anchor: Literal["start", "goal"] = "start") -> Float64Array:
    """Rotation vectors (n, 3) of a motion, rad, continuous and of any length.

    On the spheres of whole turns, ||phi|| = 2 pi n with n >= 1, every vector is the identity: a
    motion about a fixed axis passes through them, and so does one whose axis turns only as the
    vector's does. Any other motion, a noisy one included, passes beside them, where the vector
    swings about while the tool hardly turns. No continuous logarithm that tells anything about the
    motion exists there.

    Args:
        quaternions: unit quaternions (n, 4), neighbours less than half a turn apart.
        anchor: the row, first or last, whose vector is at most pi long; every other vector
            continues its neighbour's along the shortest turn between the two rows.

    Raises:
        NoContinuousLogarithm: if neighbours are half a turn apart, or the vector steps by more than
            ten times the angle turned; with the row as `index`.

    Source: Lauretti et al. 2023, eq. 9, with v_k = v_(k-1) (1 - 2 k pi / ||v_(k-1) phi||) and
        v_0 = 1.
    """
    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    backward = check.choice(anchor, "anchor", ("start", "goal")) == "goal"
    vectors, broken = core.so3_lift(np.ascontiguousarray(q[::-1]) if backward else q)
    if broken >= 0:
        index, before = (len(q) - 1 - broken, len(q) - broken) if backward else (broken, broken - 1)
        turn = np.degrees(core.so3_distance(q[[before]], q[[index]])[0])
        raise NoContinuousLogarithm(
            f"quaternions: no rotation vector of sample {index} continues that of sample {before}, "
            f"{turn:.4g} degrees away (half a turn, or beside a whole number of turns)",
            index=index,
        )
    return np.ascontiguousarray(vectors[::-1]) if backward else vectors


def to_matrix(quaternions: ArrayLike) -> Float64Array:
    """Rotation matrices (n, 3, 3)."""
    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    return np.asarray(core.so3_to_matrix(q).reshape(-1, 3, 3))


def from_matrix(matrices: ArrayLike) -> Float64Array:
    """Unit quaternions (n, 4), w >= 0, of the rotations nearest to matrices.

    Args:
        matrices: (n, 3, 3).

    Raises:
        InvalidInput: if M^T M is off the identity by more than 0.01, or the determinant is
            negative (a reflection).

    Source: Higham 1986, "Computing the polar decomposition" (Newton).
    """
    m = check.array(matrices, "matrices", shape=("n", 3, 3))
    _check_rotations(m)
    for _ in range(NEWTON_STEPS):
        m = 0.5 * (m + np.linalg.inv(m).transpose(0, 2, 1))
    return core.so3_from_matrix(np.ascontiguousarray(m).reshape(-1, 9))


def _check_rotations(matrices: Float64Array) -> None:
    # Entries beyond 2 are no rotation's, and their products might overflow.
    clipped = np.clip(matrices, -2.0, 2.0)
    off = np.abs(clipped.transpose(0, 2, 1) @ clipped - np.eye(3)).max(axis=(1, 2), initial=0.0)
    wrong = (off > ROTATION_TOLERANCE) | (np.linalg.det(clipped) < 0)
    if wrong.any():
        i = int(np.argmax(wrong))
        raise InvalidInput(
            f"matrices: expected rotations, got {matrices[i].tolist()} at index {i}, "
            f"determinant {np.linalg.det(clipped[i]):.4g}"
        )


def from_euler(angles: ArrayLike, *, convention: str) -> Float64Array:
    """Unit quaternions (n, 4) of Euler angles.

    Args:
        angles: rad, (n, 3).
        convention: three axes in the order of the angles; capital letters ("ZYZ") turn about the
            moving axes, small ones ("xyz") about the fixed ones.
    """
    checked = check.array(angles, "angles", shape=("n", 3))
    axes = check.choice(convention, "convention", CONVENTIONS)
    first, second, third = (
        core.so3_exp(angle[:, None] * np.eye(3)["XYZ".index(axis)])
        for axis, angle in zip(axes.upper(), checked.T, strict=True)
    )
    if axes.isupper():
        first, third = third, first
    return core.so3_compose(third, core.so3_compose(second, first))


def to_euler(quaternions: ArrayLike, *, convention: str) -> Float64Array:
    """Euler angles (n, 3), rad, of rotations.

    At the ends of the second angle's range (gimbal lock) only the sum or difference of the others
    is defined: SciPy then warns (UserWarning) and the third is 0. Angles jump where they wrap and
    next to gimbal lock.

    Args:
        quaternions: unit quaternions (n, 4).
        convention: as in `from_euler`.

    Returns:
        The first and third angle from -pi to pi; the second from 0 to pi where the first and third
        axis are the same, else from -pi/2 to pi/2.
    """
    from scipy.spatial.transform import Rotation

    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    axes = check.choice(convention, "convention", CONVENTIONS)
    if len(q) == 0:
        return np.zeros((0, 3))
    return np.asarray(Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_euler(axes))


def mean(quaternions: ArrayLike, *, weights: ArrayLike | None = None) -> Float64Array:
    """The rotation with the least weighted sum of squared distances (Karcher mean).

    Args:
        quaternions: unit quaternions (k, 4), or (k, n, 4) for n means of k rotations each.
        weights: one for each of the k rotations, >= 0, not all 0; equal by default.

    Returns:
        A quaternion (4,), or (n, 4), with the sign of the nearer of the first rotation's two
        quaternions.

    Raises:
        InvalidInput: if rotations of weight > 0 lie a quarter turn or more from their unweighted
            middle, where more than one mean is possible.

    Source: Markley et al. 2007, "Averaging quaternions", for the start; Manton 2004, "A
        globally convergent numerical algorithm for computing the centre of mass on compact Lie
        groups".
    """
    single = check.rank(quaternions) == 2
    shape = ("k", 4) if single else ("k", "n", 4)
    layers = check.quaternions(quaternions, "quaternions", shape=shape)
    if len(layers) == 0:
        raise InvalidInput("quaternions: expected at least one rotation, got none")
    factors = _weights(weights, len(layers))
    kept = np.ascontiguousarray(layers[factors > 0]).reshape(-1, 4)
    means, reach = core.so3_mean(kept, factors[factors > 0])
    if (reach > MAX_REACH).any():
        i = int(np.argmax(reach > MAX_REACH))
        where = "" if single else f" in mean {i}"
        raise InvalidInput(
            "quaternions: expected rotations within a quarter turn of their middle, "
            f"got one {np.degrees(reach[i]):.4g} degrees away{where}"
        )
    return means[0] if single else means


def _weights(weights: ArrayLike | None, count: int) -> Float64Array:
    if weights is None:
        return np.ones(count)
    factors = check.array(weights, "weights", shape=(count,))
    if (factors < 0).any() or not factors.any():
        raise InvalidInput(f"weights: expected numbers >= 0, not all 0, got {factors}")
    return np.asarray(factors / factors.max())


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
