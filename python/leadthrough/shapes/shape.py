"""The questions that every shape answers: distance, bounds, surface, convex parts, inertia.

Planners, the command line, the simulation and the pages ask the shape itself, so that a new one is
one class and a line of `SHAPES`.
"""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.shapes.surface import Surface

IDENTITY = (1.0, 0.0, 0.0, 0.0)
_MAX_COORDINATE = 1e6  # m; beyond, rounding would exceed the size of thin parts


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """A convex part of a shape in the base frame, for simulators."""

    kind: str  # "box", "sphere", "capsule", "cylinder" or "mesh", the convex hull of its vertices
    half_sizes: tuple[float, ...]  # radii and half lengths, m; of a mesh ()
    position: Float64Array  # (3,), m
    orientation: Float64Array  # (4,), w, x, y, z
    vertices: Float64Array | None = None  # (n, 3), m, of a mesh in its own frame


class Shape(ShortRepr, ABC):
    """A shape at a pose in the base frame."""

    position: Float64Array  # (3,), m
    orientation: Float64Array  # (4,), w, x, y, z

    @property
    def middle(self) -> Float64Array:
        """Centre (3,), m, of the ball and of the box that bound it, in the base frame."""
        return self.position

    @property
    @abstractmethod
    def bounding_radius(self) -> float:
        """Radius of a ball around its middle that contains it, m."""

    @property
    @abstractmethod
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""

    @abstractmethod
    def surface(self) -> Surface:
        """Its surface in its own frame, to be drawn."""

    @abstractmethod
    def convex_parts(self) -> Iterator[ConvexPart]:
        """Convex parts that cover it, in the base frame."""

    @abstractmethod
    def _compile(self) -> core.Shape:
        """The shape for the compiled core, made anew."""

    def at(self, position: ArrayLike, orientation: ArrayLike | None = None) -> Self:
        """The same shape at another pose.

        Args:
            position: (3,), m in the base frame.
            orientation: (4,) w, x, y, z; by default as before. A sphere has none and ignores it.
        """
        here = pose(position, IDENTITY if orientation is None else orientation)
        if orientation is None:
            del here["orientation"]
        moved = copy(self)
        vars(moved).update((name, here[name]) for name in here if name in self._fields)
        return moved

    def turned(self, vector: ArrayLike) -> Self:
        """The same shape, turned about its position by a rotation vector (3,), rad, base frame."""
        turn = rotations.exp(check.array(vector, "vector", shape=(3,))[None])
        return self.at(self.position, rotations.compose(turn, self.orientation[None])[0])

    def placed_surface(self) -> Surface:
        """Its surface in the base frame."""
        return self.surface().moved(self.position, self._rotation)

    def distance(self, points: ArrayLike) -> Float64Array:
        """Signed distances (n,) of points, m; of several parts, to the nearest or deepest one.

        Args:
            points: m in the base frame, (n, 3).
        """
        return self._compiled.distances(check.array(points, "points", shape=("n", 3)))

    @cached_property
    def _compiled(self) -> core.Shape:
        return self._compile()

    @cached_property
    def _rotation(self) -> Float64Array:
        """The rotation (3, 3) from the shape's own frame to the base's."""
        return np.asarray(rotations.to_matrix(self.orientation[None])[0])

    @property
    def _fields(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]

    def form(self) -> str:
        """A text that only shapes of this kind, size and orientation have, at any position."""
        total = hashlib.sha256()
        for name, value in sorted(self._fields.items()):
            if name not in ("position", "parts"):  # parts follow from vertices and faces
                array = np.round(np.asarray(value, dtype=np.float64), 9) + 0.0
                total.update(f"{name}{array.shape}".encode() + array.tobytes())
        return f"{type(self).__name__} {total.hexdigest()[:12]}"


class Solid(Shape):
    """A shape with a volume, which an arm can carry."""

    @abstractmethod
    def unit_inertia(self) -> tuple[Float64Array, Float64Array]:
        """Centre (3,), m, and inertia (3, 3) about it, m^2, of 1 kg of it, in the base frame."""


class Primitive(Solid):
    """A convex solid about its position, known by a few sizes."""

    size_names: ClassVar[str]  # separated by commas, as on the command line

    @classmethod
    def kind(cls) -> str:
        """Its name on the command line, in the core and in URDFs."""
        return cls.__name__.lower()

    @classmethod
    @abstractmethod
    def from_sizes(cls, sizes: Float64Array, *pose: ArrayLike) -> Self:
        """The solid of the sizes that `size_names` lists, m."""

    @property
    @abstractmethod
    def sizes(self) -> Float64Array:
        """The sizes that `size_names` lists, m."""

    @property
    @abstractmethod
    def _half_sizes(self) -> tuple[float, ...]:
        """Its radii and half lengths, m."""

    @abstractmethod
    def _moments(self) -> Float64Array:
        """Principal moments (3,) about its middle, for a mass of one."""

    def option(self) -> str:
        """Its text on the command line, to 0.01 mm: box:0.1,0.1,0.4@0.5,0,0.2/1,0,0,0."""
        sizes, position, orientation = map(
            option_numbers, (self.sizes, self.position, self.orientation)
        )
        return f"{self.kind()}:{sizes}@{position}/{orientation}"

    def unit_inertia(self) -> tuple[Float64Array, Float64Array]:
        return self.position, (self._rotation * self._moments()) @ self._rotation.T

    def convex_parts(self) -> Iterator[ConvexPart]:
        yield ConvexPart(self.kind(), self._half_sizes, self.position, self.orientation)

    def _compile(self) -> core.Shape:
        return core.primitive_shape(self.kind(), self.sizes, self.position, self.orientation)


class PointBased(Shape):
    """A shape that is known by points: its corners, or the centres of its balls."""

    @property
    def middle(self) -> Float64Array:
        lower, upper = self._corners
        return 0.5 * (lower + upper)

    @property
    def half_extents(self) -> Float64Array:
        lower, upper = self._corners
        return 0.5 * (upper - lower) + self._rounding

    @cached_property
    def bounding_radius(self) -> float:
        return float(length(self._outline() - self.middle).max()) + self._rounding

    @cached_property
    def _corners(self) -> tuple[Float64Array, Float64Array]:
        outline = self._outline()
        return outline.min(axis=0), outline.max(axis=0)

    @abstractmethod
    def _outline(self) -> Float64Array:
        """The points (n, 3), m in the base frame."""

    @property
    def _rounding(self) -> float:
        """Distance that the shape extends beyond its points, m."""
        return 0.0


def pose(position: ArrayLike, orientation: ArrayLike) -> dict[str, Float64Array]:
    """A position (3,) and a unit quaternion (4,), read-only, by their names."""
    centre = check.frozen(position, "position", shape=(3,))
    quaternion = check.quaternions(orientation, "orientation", shape=(4,))
    return {"position": centre, "orientation": check.freeze(quaternion)}


def checked_points(value: ArrayLike, name: str) -> Float64Array:
    """Points (n, 3), read-only, near enough to the origin to be measured."""
    points = check.frozen(value, name, shape=("n", 3))
    farthest = float(np.abs(points).max(initial=0.0))
    if farthest > _MAX_COORDINATE:
        raise check.refused(name, f"coordinates within {_MAX_COORDINATE:g} m", f"{farthest:.3g} m")
    return points


def length(vectors: Float64Array) -> Float64Array:
    """Lengths (n,) of vectors (n, 3), many times faster than NumPy's reduction over three."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def option_numbers(values: Float64Array) -> str:
    """Numbers as the command line has them, to the fifth decimal."""
    return ",".join(f"{x + 0.0:g}" for x in np.round(values, 5))
