"""Euler angles in all twelve conventions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array

_INTRINSIC = tuple(a + b + c for a in "XYZ" for b in "XYZ" for c in "XYZ" if b not in (a, c))
CONVENTIONS = (*_INTRINSIC, *(convention.lower() for convention in _INTRINSIC))


def from_euler(angles: ArrayLike, *, convention: str) -> Float64Array:
    """Unit quaternions (n, 4) of Euler angles.

    Args:
        angles: rad, (n, 3).
        convention: three axes in the order of the angles; capital letters ("ZYZ") turn about the
            moving axes, small ones ("xyz") about the fixed ones.

    Raises:
        InvalidInput: if the angles are not finite numbers of that shape, or the convention is none.
    """
    checked = check.array(angles, "angles", shape=("n", 3))
    axes = check.choice(convention, "convention", CONVENTIONS)
    first, second, third = (
        _core.so3_exp(angle[:, None] * np.eye(3)["XYZ".index(axis)])
        for axis, angle in zip(axes.upper(), checked.T, strict=True)
    )
    if axes.isupper():
        first, third = third, first
    return _core.so3_compose(third, _core.so3_compose(second, first))


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

    Raises:
        InvalidInput: if they are not unit quaternions of that shape, or the convention is none.
    """
    from scipy.spatial.transform import Rotation

    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    axes = check.choice(convention, "convention", CONVENTIONS)
    if len(q) == 0:
        return np.zeros((0, 3))
    return np.asarray(Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_euler(axes))
