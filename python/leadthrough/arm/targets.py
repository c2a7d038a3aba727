"""Targets and seeds of inverse kinematics, checked and as the core takes them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_FREE = np.empty(0)
_FREE_ROWS = np.empty((0, 4))


def one_pose(
    position: ArrayLike, orientation: ArrayLike | None
) -> tuple[Float64Array, Float64Array]:
    """A position (3,) and an orientation (4,), or (0,) where it is free."""
    where = check.array(position, "position", shape=(3,))
    if orientation is None:
        return where, _FREE
    return where, check.quaternions(orientation, "orientation", shape=(4,))


def many_poses(
    positions: ArrayLike, orientations: ArrayLike | None
) -> tuple[Float64Array, Float64Array]:
    """Positions (m, 3) and orientations (m, 4), or (0, 4) where they are free."""
    where = check.array(positions, "positions", shape=("m", 3))
    if orientations is None:
        return where, _FREE_ROWS
    return where, check.quaternions(orientations, "orientations", shape=(len(where), 4))


def many_seeds(seeds: ArrayLike | None, count: int, *, default: Float64Array) -> Float64Array:
    """Seeds (count, joints) from as many rows, from one for all, or from the default (joints,)."""
    joints = len(default)
    if seeds is not None and np.ndim(seeds) == 2:
        return check.array(seeds, "seeds", shape=(count, joints))
    one = default if seeds is None else check.array(seeds, "seeds", shape=(joints,))
    return np.tile(one, (count, 1))


def require_position_axis(free: Collection[str], orientation: ArrayLike | None) -> None:
    """Check that a target without orientation leaves at least one axis to reach."""
    if orientation is None and set(free) >= {"x", "y", "z"}:
        raise InvalidInput(
            "free: expected at least one of 'x', 'y', 'z' not to be free without an orientation"
        )
