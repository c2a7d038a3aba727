"""How far the tip may be away from the samples of its path where the arm needs the room.

The first sample and the last one stay: there the motion begins, and does what it is for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, rotations
from leadthrough.arm.tracks import TipPath
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput


def tube_around(path: TipPath, deviation: tuple[ArrayLike, ArrayLike]) -> Float64Array:
    """The room at each sample as the core takes it, (6 n, 6)."""
    if not isinstance(deviation, tuple | list) or len(deviation) != 2:
        raise InvalidInput(
            f"deviation: expected the room in m and in rad, (m, rad), got {deviation!r}"
        )
    room = np.zeros((len(path), 6, 6))
    room[:, :3, :3] = _in_frames(path, _room(deviation[0], "deviation in m", len(path)))
    room[:, 3:, 3:] = _room(deviation[1], "deviation in rad", len(path))
    room[[0, -1]] = 0.0
    return np.ascontiguousarray(room.reshape(-1, 6))


def _room(value: ArrayLike, name: str, samples: int) -> Float64Array:
    """Squares (3, 3) along the axes, or the matrices (n, 3, 3) as they are."""
    if np.ndim(value) == 0:
        return np.diag(np.full(3, check.number(value, name, at_least=0.0) ** 2))
    if np.ndim(value) == 1:
        lengths = check.array(value, name, shape=(3,))
        if lengths.min() < 0.0:
            raise InvalidInput(f"{name}: expected numbers >= 0, got {lengths.min()}")
        return np.diag(lengths**2)
    matrices = check.array(value, name, shape=(samples, 3, 3))
    if not all(_core.is_covariance(np.ascontiguousarray(each)) for each in matrices):
        raise InvalidInput(
            f"{name}: expected covariances, symmetric and without negative variances"
        )
    return matrices


def _in_frames(path: TipPath, room: Float64Array) -> Float64Array:
    """Room given by matrices in the base frame as seen from each sample."""
    if room.ndim == 2 or not len(path.orientations):
        return room
    frames = rotations.to_matrix(path.orientations)
    return np.asarray(frames.transpose(0, 2, 1) @ room @ frames)
