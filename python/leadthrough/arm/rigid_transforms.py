"""Rigid transforms in batches: products, inverses and differences of poses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput

# Position (3,) in m and orientation (4,) w, x, y, z.
Pose = tuple[ArrayLike, ArrayLike]
GivenT = TypeVar("GivenT")
MadeT = TypeVar("MadeT")


@dataclass(frozen=True, eq=False)
class Transforms:
    """Poses of one frame in another; one of several operands may have a single row."""

    positions: Float64Array  # (n, 3) m
    orientations: Float64Array  # (n, 4) w, x, y, z

    @staticmethod
    def of(pose: Pose, name: str) -> Transforms:
        """The single pose that a user gave as (position, orientation)."""
        if not isinstance(pose, tuple | list) or len(pose) != 2:
            raise InvalidInput(f"{name}: expected (position, orientation), got {pose!r}")
        position = check.frozen(pose[0], f"{name} position", shape=(3,))
        orientation = check.quaternions(pose[1], f"{name} orientation", shape=(4,))
        return Transforms(position[None], check.freeze(orientation)[None])

    @staticmethod
    def identity() -> Transforms:
        return Transforms(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]))

    def __matmul__(self, other: Transforms) -> Transforms:
        """The frames of `other`, which is given in the frames of self."""
        count = max(len(self.positions), len(other.positions))
        first, second = (np.broadcast_to(q.orientations, (count, 4)) for q in (self, other))
        points = np.broadcast_to(other.positions, (count, 3))
        rotated = np.einsum("nij,nj->ni", rotations.to_matrix(first), points)
        return Transforms(self.positions + rotated, rotations.compose(first, second))

    def single(self) -> tuple[Float64Array, Float64Array]:
        return self.positions[0], self.orientations[0]

    def matrices(self) -> Float64Array:
        """Rotation matrices (n, 3, 3)."""
        return rotations.to_matrix(self.orientations)

    def continuous(self) -> Transforms:
        """The same poses with signs of quaternions that do not leap."""
        return Transforms(self.positions, rotations.align_signs(self.orientations))

    def inverse(self) -> Self:
        back = rotations.inverse(self.orientations)
        positions = -np.einsum("nij,nj->ni", rotations.to_matrix(back), self.positions)
        return type(self)(positions, back)

    def distances(self, other: Transforms) -> tuple[Float64Array, Float64Array]:
        """Distances (n,) in m and angles (n,) in rad between poses."""
        away = np.linalg.norm(self.positions - other.positions, axis=1)
        count = len(away)
        first, second = (np.broadcast_to(q.orientations, (count, 4)) for q in (self, other))
        return away, rotations.distance(first, second)


def checked_grasps(
    grasps: tuple[GivenT, GivenT], of: Callable[[GivenT, str], MadeT]
) -> tuple[MadeT, MadeT]:
    """Poses of the left and the right tip in an object's frame, each made by `of`."""
    if not isinstance(grasps, tuple | list) or len(grasps) != 2:
        raise check.refused("grasps", "the poses of the left and the right tip", repr(grasps))
    return of(grasps[0], "grasps[0]"), of(grasps[1], "grasps[1]")
