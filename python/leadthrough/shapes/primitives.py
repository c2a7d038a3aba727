"""Boxes, spheres, capsules and cylinders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.shapes import surface
from leadthrough.shapes.shape import IDENTITY, ConvexPart, Primitive, pose
from leadthrough.shapes.surface import Surface


@dataclass(frozen=True, eq=False, init=False)
class Box(Primitive):
    """A box about its centre.

    Attributes:
        size: full edge lengths (3,), m, > 0.
        position: centre (3,), m.
        orientation: w, x, y, z of the box in the base frame, (4,); parallel to the axes by
            default.
    """

    size_names = "SX,SY,SZ"
    size: Float64Array
    position: Float64Array
    orientation: Float64Array

    def __init__(
        self, size: ArrayLike, position: ArrayLike, orientation: ArrayLike = IDENTITY
    ) -> None:
        edges = check.frozen(size, "size", shape=(3,))
        for edge in edges:
            check.number(edge, "size", above=0.0)
        vars(self).update(size=edges, **pose(position, orientation))

    @classmethod
    def from_sizes(cls, sizes: Float64Array, *pose: ArrayLike) -> Self:
        return cls(sizes, *pose)

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return float(0.5 * np.linalg.norm(self.size))

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        return np.asarray(np.abs(self._rotation) @ (0.5 * self.size))

    def surface(self) -> Surface:
        return surface.box(self.size)

    @property
    def sizes(self) -> Float64Array:
        return self.size

    @property
    def _half_sizes(self) -> tuple[float, ...]:
        return tuple(0.5 * self.size)

    def _moments(self) -> Float64Array:
        squares = self.size**2
        return np.asarray((squares.sum() - squares) / 12.0)


@dataclass(frozen=True, eq=False, init=False)
class Sphere(Primitive):
    """A ball.

    Attributes:
        radius: m, > 0.
        position: centre (3,), m.
    """

    size_names = "R"
    radius: float
    position: Float64Array
    orientation = check.frozen(IDENTITY, "orientation", shape=(4,))

    def __init__(self, radius: float, position: ArrayLike) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            position=check.frozen(position, "position", shape=(3,)),
        )

    @classmethod
    def from_sizes(cls, sizes: Float64Array, *pose: ArrayLike) -> Self:
        if len(pose) > 1:
            raise InvalidInput("a sphere takes no quaternion")
        return cls(float(sizes[0]), *pose)

    @property
    def bounding_radius(self) -> float:
        """Its radius, m."""
        return self.radius

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box."""
        return np.full(3, self.radius)

    def surface(self) -> Surface:
        return surface.sphere(self.radius)

    @property
    def sizes(self) -> Float64Array:
        return np.array([self.radius])

    @property
    def _half_sizes(self) -> tuple[float, ...]:
        return (self.radius,)

    def _moments(self) -> Float64Array:
        return np.full(3, 0.4 * self.radius**2)


@dataclass(frozen=True, eq=False, init=False)
class _Round(Primitive):
    """A solid of revolution about its own z axis, with a radius and a length."""

    size_names = "R,L"
    radius: float
    length: float
    position: Float64Array
    orientation: Float64Array
    _length_range: ClassVar[Mapping[str, float]]

    def __init__(
        self,
        radius: float,
        length: float,
        position: ArrayLike,
        orientation: ArrayLike = IDENTITY,
    ) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            length=check.number(length, "length", **self._length_range),
            **pose(position, orientation),
        )

    @classmethod
    def from_sizes(cls, sizes: Float64Array, *pose: ArrayLike) -> Self:
        return cls(float(sizes[0]), float(sizes[1]), *pose)

    @property
    def sizes(self) -> Float64Array:
        return np.array([self.radius, self.length])

    @property
    def _half_sizes(self) -> tuple[float, ...]:
        return self.radius, 0.5 * self.length


@dataclass(frozen=True, eq=False, init=False)
class Capsule(_Round):
    """A cylinder along its own z axis with a half ball at each end.

    Attributes:
        radius: m, > 0.
        length: distance between the centres of the balls, m, >= 0.
        position: middle (3,), m.
        orientation: w, x, y, z of the capsule in the base frame, (4,); along the base's z axis by
            default.
    """

    _length_range: ClassVar = {"at_least": 0.0}

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return self.radius + 0.5 * self.length

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        return np.asarray(self.radius + 0.5 * self.length * np.abs(self._rotation[:, 2]))

    def surface(self) -> Surface:
        return surface.capsule(self.radius, self.length)

    def convex_parts(self) -> Iterator[ConvexPart]:
        if self.length > 0.0:
            return super().convex_parts()
        return Sphere(self.radius, self.position).convex_parts()  # simulators take no length of 0

    def _moments(self) -> Float64Array:
        r, length = self.radius, self.length
        cylinder = length / (length + 4.0 / 3.0 * r)  # its fraction of the volume
        balls = 1.0 - cylinder
        along = cylinder * r**2 / 2.0 + balls * 0.4 * r**2
        across = cylinder * (length**2 / 12.0 + r**2 / 4.0) + balls * (
            0.4 * r**2 + length**2 / 4.0 + 3.0 / 8.0 * length * r
        )
        return np.array([across, across, along])


@dataclass(frozen=True, eq=False, init=False)
class Cylinder(_Round):
    """A cylinder along its own z axis.

    Attributes:
        radius: m, > 0.
        length: distance between its flat ends, m, > 0.
        position: middle (3,), m.
        orientation: w, x, y, z of the cylinder in the base frame, (4,); along the base's z axis by
            default.
    """

    _length_range: ClassVar = {"above": 0.0}

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return float(np.hypot(self.radius, 0.5 * self.length))

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        reach = np.abs(self._rotation)
        across = np.hypot(reach[:, 0], reach[:, 1])
        return np.asarray(self.radius * across + 0.5 * self.length * reach[:, 2])

    def surface(self) -> Surface:
        return surface.cylinder(self.radius, self.length)

    def _moments(self) -> Float64Array:
        along = 0.5 * self.radius**2
        across = self.length**2 / 12.0 + 0.5 * along
        return np.array([across, across, along])


PRIMITIVES: dict[str, type[Primitive]] = {
    kind.kind(): kind for kind in (Box, Sphere, Capsule, Cylinder)
}
