"""Obstacles as convex primitives with a signed distance: negative inside, zero on the surface."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_UNTURNED = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Box:
    """A box about its centre.

    size: (3,) full edge lengths, m, > 0. position: (3,) centre, m.
    orientation: (4,) w, x, y, z of the box in the base frame.
    """

    size: Float64Array
    position: Float64Array
    orientation: Float64Array = _UNTURNED  # type: ignore[assignment]

    def __post_init__(self) -> None:
        size = check.frozen(self.size, "size", shape=(3,))
        for edge in size:
            check.number(edge, "size", above=0.0)
        object.__setattr__(self, "size", size)
        _freeze_pose(self)

    def distance(self, points: Any) -> Float64Array:
        """Signed distance (n,) of points (n, 3) in the base frame, m. Raises InvalidInput."""
        outside = np.abs(_to_local(self, points)) - 0.5 * self.size
        deepest = np.maximum(np.maximum(outside[:, 0], outside[:, 1]), outside[:, 2])
        return _length(np.maximum(outside, 0.0)) + np.minimum(deepest, 0.0)


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball. radius: m, > 0. position: (3,) centre, m."""

    radius: float
    position: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", check.number(self.radius, "radius", above=0.0))
        object.__setattr__(self, "position", check.frozen(self.position, "position", shape=(3,)))

    def distance(self, points: Any) -> Float64Array:
        """Signed distance (n,) of points (n, 3) in the base frame, m. Raises InvalidInput."""
        p = check.array(points, "points", shape=("n", 3))
        return _length(p - self.position) - self.radius


@dataclass(frozen=True, eq=False)
class Capsule:
    """A cylinder along its own z with half balls beyond both ends.

    radius: m, > 0. length: m between the centres of the balls, >= 0. position: (3,) middle, m.
    orientation: (4,) w, x, y, z of the capsule in the base frame.
    """

    radius: float
    length: float
    position: Float64Array
    orientation: Float64Array = _UNTURNED  # type: ignore[assignment]

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", check.number(self.radius, "radius", above=0.0))
        object.__setattr__(self, "length", check.number(self.length, "length", at_least=0.0))
        _freeze_pose(self)

    def distance(self, points: Any) -> Float64Array:
        """Signed distance (n,) of points (n, 3) in the base frame, m. Raises InvalidInput."""
        local = _to_local(self, points)
        half = 0.5 * self.length
        local[:, 2] -= np.clip(local[:, 2], -half, half)
        return _length(local) - self.radius


Shape = Box | Sphere | Capsule


def check_shapes(obstacles: Iterable[Shape]) -> tuple[Shape, ...]:
    """The obstacles, if all are shapes. Raises InvalidInput."""
    if not isinstance(obstacles, Iterable):
        raise InvalidInput(f"obstacles: expected a sequence, got {type(obstacles).__name__}")
    shapes = tuple(obstacles)
    for shape in shapes:
        if not isinstance(shape, Box | Sphere | Capsule):
            raise InvalidInput(
                f"obstacles: expected Box, Sphere or Capsule, got {type(shape).__name__}"
            )
    return shapes


def _freeze_pose(shape: Box | Capsule) -> None:
    object.__setattr__(shape, "position", check.frozen(shape.position, "position", shape=(3,)))
    orientation = check.quaternions(shape.orientation, "orientation", shape=(4,))
    orientation.setflags(write=False)
    object.__setattr__(shape, "orientation", orientation)


def _length(vectors: Float64Array) -> Float64Array:
    """Lengths (n,) of vectors (n, 3): many times quicker than NumPy's reduction over three."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def _to_local(shape: Box | Capsule, points: Any) -> Float64Array:
    offsets = check.array(points, "points", shape=("n", 3)) - shape.position
    return np.asarray(offsets @ rotations.to_matrix(shape.orientation[None])[0])
