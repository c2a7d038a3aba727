"""The group of rotations: exponential, logarithm, product, inverse, distance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput


def exp(rotation_vectors: ArrayLike) -> Float64Array:
    """Unit quaternions (n, 4) of rotation vectors.

    Args:
        rotation_vectors: axis times angle, rad, (n, 3), of any length.

    Raises:
        InvalidInput: if they are not finite numbers of that shape.
    """
    return _core.so3_exp(check.array(rotation_vectors, "rotation_vectors", shape=("n", 3)))


def log(quaternions: ArrayLike) -> Float64Array:
    """Rotation vectors (n, 3), rad, of length at most pi.

    Args:
        quaternions: unit quaternions (n, 4). q and -q have the same logarithm, except at exactly
            pi, where the sign of the vector is q's.

    Raises:
        InvalidInput: if they are not unit quaternions of that shape.
    """
    return _core.so3_log(check.quaternions(quaternions, "quaternions", shape=("n", 4)))


def compose(a: ArrayLike, b: ArrayLike) -> Float64Array:
    """Quaternions (n, 4) of the rotations that turn by b first, then by a.

    Args:
        a: unit quaternions (n, 4).
        b: unit quaternions (n, 4).

    Raises:
        InvalidInput: if they are not unit quaternions, as many in one as in the other.
    """
    return _core.so3_compose(*pair(a, b))


def inverse(quaternions: ArrayLike) -> Float64Array:
    """Quaternions (n, 4) of the opposite rotations.

    Args:
        quaternions: unit quaternions (n, 4).

    Raises:
        InvalidInput: if they are not unit quaternions of that shape.
    """
    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    return np.asarray(q * [1.0, -1.0, -1.0, -1.0])


def distance(a: ArrayLike, b: ArrayLike) -> Float64Array:
    """Geodesic distances (n,) between rotations, from 0 to pi rad, whatever the signs.

    Args:
        a: unit quaternions (n, 4).
        b: unit quaternions (n, 4).

    Raises:
        InvalidInput: if they are not unit quaternions, as many in one as in the other.
    """
    return _core.so3_distance(*pair(a, b))


def align_signs(quaternions: ArrayLike) -> Float64Array:
    """The same rotations (n, 4) with signs chosen so that neighbours lie in one hemisphere.

    Args:
        quaternions: unit quaternions (n, 4), of which the first keeps its sign.

    Raises:
        InvalidInput: if they are not unit quaternions of that shape.
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
