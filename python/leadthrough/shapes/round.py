"""Spheres, capsules and cylinders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.shapes.placed import UNTURNED, Placed, Turned, pose


@dataclass(frozen=True, eq=False, init=False)
class Sphere(Placed):
    """A ball.

    Attributes:
        radius: m, > 0.
        position: centre (3,), m.

    Raises:
        InvalidInput: if one of them is malformed or the radius is not > 0.
    """

    radius: float
    position: Float64Array

    def __init__(self, radius: float, position: ArrayLike) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            position=check.frozen(position, "position", shape=(3,)),
        )

    @property
    def bounding_radius(self) -> float:
        """Its radius, m."""
        return self.radius

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box."""
        return np.full(3, self.radius)

    def _compile(self) -> _core.Shape:
        return _core.sphere_shape(self.radius, self.position)


@dataclass(frozen=True, eq=False, init=False)
class Capsule(Turned):
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

    def __init__(
        self,
        radius: float,
        length: float,
        position: ArrayLike,
        orientation: ArrayLike = UNTURNED,
    ) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            length=check.number(length, "length", at_least=0.0),
            **pose(position, orientation),
        )

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return self.radius + 0.5 * self.length

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        return np.asarray(self.radius + 0.5 * self.length * np.abs(self._matrix[:, 2]))

    def _compile(self) -> _core.Shape:
        return _core.capsule_shape(self.radius, self.length, self.position, self.orientation)


@dataclass(frozen=True, eq=False, init=False)
class Cylinder(Turned):
    """A cylinder along its own z axis.

    Attributes:
        radius: m, > 0.
        length: distance between its flat ends, m, > 0.
        position: middle (3,), m.
        orientation: w, x, y, z of the cylinder in the base frame, (4,); along the base's z axis by
            default.

    Raises:
        InvalidInput: if one of them is malformed or out of its range.
    """

    radius: float
    length: float
    position: Float64Array
    orientation: Float64Array

    def __init__(
        self,
        radius: float,
        length: float,
        position: ArrayLike,
        orientation: ArrayLike = UNTURNED,
    ) -> None:
        vars(self).update(
            radius=check.number(radius, "radius", above=0.0),
            length=check.number(length, "length", above=0.0),
            **pose(position, orientation),
        )

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return float(np.hypot(self.radius, 0.5 * self.length))

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        reach = np.abs(self._matrix)
        across = np.hypot(reach[:, 0], reach[:, 1])
        return np.asarray(self.radius * across + 0.5 * self.length * reach[:, 2])

    def _compile(self) -> _core.Shape:
        return _core.cylinder_shape(self.radius, self.length, self.position, self.orientation)
