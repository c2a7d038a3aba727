"""Rotation matrices, and Euler angles in all twelve conventions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput

# A recording's rounding takes a matrix this far off; beyond, it is not a rotation.
ROTATION_TOLERANCE = 1e-2

# Newton's iteration squares the error: 1e-2, 1e-4, 1e-8, below rounding.
NEWTON_STEPS = 3
_INTRINSIC = tuple(a + b + c for a in "XYZ" for b in "XYZ" for c in "XYZ" if b not in (a, c))
CONVENTIONS = (*_INTRINSIC, *(convention.lower() for convention in _INTRINSIC))


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
