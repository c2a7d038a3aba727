"""What an arm's tip link carries: a tool, which moves the tip, loads, and the shapes of objects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import _core, check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.shapes import Box, Capsule, Shape, Sphere

# What a tensor that someone measured or printed may be off by, of its largest moment.
_INERTIA_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Load:
    """A rigid body: mass in kg, its centre (3,) in m, inertia (3, 3) about it in kg m^2."""

    mass: float
    center: Float64Array
    inertia: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", check.number(self.mass, "mass", at_least=0.0))
        object.__setattr__(self, "center", check.frozen(self.center, "center", shape=(3,)))
        object.__setattr__(self, "inertia", _inertia(self.inertia))


@dataclass(frozen=True, eq=False)
class Attachment:
    """All that is fixed to a link, in that link's frame.

    position (3,) m, orientation (4,) w, x, y, z: of the tip. loads, shapes: what is carried.
    """

    position: Float64Array = (0.0, 0.0, 0.0)  # type: ignore[assignment]
    orientation: Float64Array = (1.0, 0.0, 0.0, 0.0)  # type: ignore[assignment]
    loads: tuple[Load, ...] = ()
    shapes: tuple[Shape, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", check.frozen(self.position, "position", shape=(3,)))
        orientation = check.quaternions(self.orientation, "orientation", shape=(4,))
        orientation.setflags(write=False)
        object.__setattr__(self, "orientation", orientation)

    def with_tool(self, position: Any, orientation: Any) -> Attachment:
        """With the tip at a pose given in the frame of the tip. Raises InvalidInput."""
        where = check.array(position, "position", shape=(3,))
        turn = check.quaternions(orientation, "orientation", shape=(4,))
        return replace(self, position=self._in_link(where), orientation=self._turned(turn))

    def with_load(self, load: Load) -> Attachment:
        """With a load given in the frame of the tip."""
        turn = self._rotation()
        moments = turn @ load.inertia @ turn.T
        return replace(
            self, loads=(*self.loads, Load(load.mass, self._in_link(load.center), moments))
        )

    def with_shape(self, shape: Any, mass: Any) -> Attachment:
        """With an object whose pose is given in the frame of the tip, and of uniform density.

        Raises InvalidInput.
        """
        if not isinstance(shape, Shape):
            raise InvalidInput(f"shape: expected a Box, Sphere or Capsule, got {shape!r}")
        weight = check.number(mass, "mass", at_least=0.0)
        carried = self if weight == 0.0 else self.with_load(_solid(shape, weight))
        pose: dict[str, Any] = {"position": self._in_link(shape.position)}
        if not isinstance(shape, Sphere):
            pose["orientation"] = self._turned(shape.orientation)
        return replace(carried, shapes=(*self.shapes, replace(shape, **pose)))

    def applied_to(self, chain: _core.Chain) -> _core.Chain:
        """A chain that ends in the link, with its loads and its tip moved."""
        for load in self.loads:
            chain = chain.with_load(load.mass, load.center, load.inertia)
        return chain.with_tool(self.position, self.orientation)

    def _rotation(self) -> Float64Array:
        return _matrix(self.orientation)

    def _in_link(self, point: Float64Array) -> Float64Array:
        return np.asarray(self.position + self._rotation() @ point)

    def _turned(self, orientation: Float64Array) -> Float64Array:
        return np.asarray(rotations.compose(self.orientation[None], orientation[None])[0])


def _matrix(orientation: Float64Array) -> Float64Array:
    return np.asarray(rotations.to_matrix(orientation[None])[0])


def _inertia(value: Any) -> Float64Array:
    """A tensor that a body can have: symmetric, no moment above the sum of the other two."""
    inertia = check.frozen(value, "inertia", shape=(3, 3))
    slack = _INERTIA_TOLERANCE * float(np.abs(inertia).max())
    if np.abs(inertia - inertia.T).max() > slack:
        raise InvalidInput(f"inertia: expected a symmetric matrix, got {inertia.tolist()}")
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] < -slack or moments[0] + moments[1] < moments[2] - slack:
        raise InvalidInput(
            "inertia: expected principal moments of a body, none negative or above the sum of the "
            f"others, got {moments.tolist()}"
        )
    return inertia


def _solid(shape: Shape, mass: float) -> Load:
    if isinstance(shape, Sphere):
        return Load(mass, shape.position, 0.4 * mass * shape.radius**2 * np.eye(3))
    moments = _box_moments(shape) if isinstance(shape, Box) else _capsule_moments(shape)
    turn = _matrix(shape.orientation)
    return Load(mass, shape.position, mass * (turn * moments) @ turn.T)


def _box_moments(box: Box) -> Float64Array:
    """Principal moments (3,) of a solid box, for a mass of one."""
    squares = box.size**2
    return np.asarray((squares.sum() - squares) / 12.0)


def _capsule_moments(capsule: Capsule) -> Float64Array:
    """Principal moments (3,) of a cylinder with half balls, for a mass of one."""
    r, length = capsule.radius, capsule.length
    cylinder = length / (length + 4.0 / 3.0 * r)  # its share of the volume
    balls = 1.0 - cylinder
    along = cylinder * r**2 / 2.0 + balls * 0.4 * r**2
    across = cylinder * (length**2 / 12.0 + r**2 / 4.0) + balls * (
        0.4 * r**2 + length**2 / 4.0 + 3.0 / 8.0 * length * r
    )
    return np.array([across, across, along])
