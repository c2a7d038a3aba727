"""The group of rotations: exponential, logarithm, product, inverse, distance and continuous
logarithm."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.errors import NoContinuousLogarithm


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
