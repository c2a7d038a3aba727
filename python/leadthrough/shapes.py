"""Obstacles as convex primitives with a signed distance: negative inside, zero on the surface.

What planners and kernels have to know of a kind of shape, the shape itself answers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.brief import Brief
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_UNTURNED = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, init=False)
class Box(Brief):
    """A box about its centre.

    Attributes:
        size: full edge lengths (3,), m, > 0.
        position: centre (3,), m.
        orientation: w, x, y, z of the box in the base frame, (4,); parallel to the axes by
            default.

    Raises:
        InvalidInput: if one of them is malformed or an edge is not > 0.
    """

    size: Float64Array
    position: Float64Array
    orientation: Float64Array

    form: ClassVar[int] = 0  # number that the compiled core has for this kind of shape

    @property
    def dimensions(self) -> tuple[float, float, float]:
        """Its edge lengths, m."""
        x, y, z = self.size
        return float(x), float(y), float(z)

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return float(0.5 * np.linalg.norm(self.size))

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        return np.asarray(_turned(self.orientation) @ (0.5 * self.size))

    def __init__(
        self, size: ArrayLike, position: ArrayLike, orientation: ArrayLike = _UNTURNED
    ) -> None:
        edges = check.frozen(size, "size", shape=(3,))
        for edge in edges:
            check.number(edge, "size", above=0.0)
        vars(self).update(size=edges, **_pose(position, orientation))

    def distance(self, points: ArrayLike) -> Float64Array:
        """Signed distances (n,) of points, m.

        Args:
            points: m in the base frame, (n, 3).

        Raises:
            InvalidInput: if they are not finite points of that shape.
        """
        outside = np.abs(_to_local(self, points)) - 0.5 * self.size
        deepest = np.maximum(np.maximum(outside[:, 0], outside[:, 1]), outside[:, 2])
        return _length(np.maximum(outside, 0.0)) + np.minimum(deepest, 0.0)


@dataclass(frozen=True, eq=False, init=False)
class Sphere(Brief):
    """A ball.

    Attributes:
        radius: m, > 0.
        position: centre (3,), m.

    Raises:
        InvalidInput: if one of them is malformed or the radius is not > 0.
    """

    radius: float
    position: Float64Array

    form: ClassVar[int] = 1

    @property
    def dimensions(self) -> tuple[float, float, float]:
        """Its radius, m, and zeros."""
        return self.radius, 0.0, 0.0

    @property
    def bounding_radius(self) -> float:
        """Its radius, m."""
        return self.radius

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box."""
        return np.full(3, self.radius)

    def __init__(self, radius: float, position: ArrayLike) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            position=check.frozen(position, "position", shape=(3,)),
        )

    def distance(self, points: ArrayLike) -> Float64Array:
        """Signed distances (n,) of points, m.

        Args:
            points: m in the base frame, (n, 3).

        Raises:
            InvalidInput: if they are not finite points of that shape.
        """
        p = check.array(points, "points", shape=("n", 3))
        return _length(p - self.position) - self.radius


@dataclass(frozen=True, eq=False, init=False)
class Capsule(Brief):
    """A cylinder along its own z axis with a half ball at each end.

    Attributes:
        radius: m, > 0.
        length: distance between the centres of the balls, m, >= 0.
        position: middle (3,), m.
        orientation: w, x, y, z of the capsule in the base frame, (4,); along the base's z axis by
            default.

    Raises:
        InvalidInput: if one of them is malformed or out of its range.
    """

    radius: float
    length: float
    position: Float64Array
    orientation: Float64Array

    form: ClassVar[int] = 2

    @property
    def dimensions(self) -> tuple[float, float, float]:
        """Its radius and length, m, and zero."""
        return self.radius, self.length, 0.0

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return self.radius + 0.5 * self.length

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        along = _turned(self.orientation)[:, 2]
        return np.asarray(self.radius + 0.5 * self.length * along)

    def __init__(
        self,
        radius: float,
        length: float,
        position: ArrayLike,
        orientation: ArrayLike = _UNTURNED,
    ) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            length=check.number(length, "length", at_least=0.0),
            **_pose(position, orientation),
        )

    def distance(self, points: ArrayLike) -> Float64Array:
        """Signed distances (n,) of points, m.

        Args:
            points: m in the base frame, (n, 3).

        Raises:
            InvalidInput: if they are not finite points of that shape.
        """
        local = _to_local(self, points)
        half = 0.5 * self.length
        local[:, 2] -= np.clip(local[:, 2], -half, half)
        return _length(local) - self.radius


Shape = Box | Sphere | Capsule


def check_shapes(obstacles: Iterable[Shape]) -> tuple[Shape, ...]:
    """The obstacles, if all are shapes.

    Args:
        obstacles: boxes, spheres and capsules.

    Raises:
        InvalidInput: if they are no sequence, or one of them is no shape.
    """
    if not isinstance(obstacles, Iterable):
        raise InvalidInput(f"obstacles: expected a sequence, got {type(obstacles).__name__}")
    shapes = tuple(obstacles)
    for shape in shapes:
        if not isinstance(shape, Box | Sphere | Capsule):
            raise InvalidInput(
                f"obstacles: expected Box, Sphere or Capsule, got {type(shape).__name__}"
            )
    return shapes


def _pose(position: ArrayLike, orientation: ArrayLike) -> dict[str, Float64Array]:
    """A position (3,) and a unit quaternion (4,), read-only, by their names."""
    centre = check.frozen(position, "position", shape=(3,))
    quaternion = check.quaternions(orientation, "orientation", shape=(4,))
    quaternion.setflags(write=False)
    return {"position": centre, "orientation": quaternion}


def _turned(orientation: Float64Array) -> Float64Array:
    """How far (3, 3) each of a shape's unit axes, in columns, reaches along the base's axes."""
    return np.asarray(np.abs(rotations.to_matrix(orientation[None])[0]))


def _length(vectors: Float64Array) -> Float64Array:
    """Lengths (n,) of vectors (n, 3), many times faster than NumPy's reduction over three."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def _to_local(shape: Box | Capsule, points: ArrayLike) -> Float64Array:
    """Points (n, 3) in the shape's own frame."""
    offsets = check.array(points, "points", shape=("n", 3)) - shape.position
    return np.asarray(offsets @ rotations.to_matrix(shape.orientation[None])[0])
