"""Load of an arm's tip link: a tool, which moves the tip, masses and the shapes of objects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr, numbers_text
from leadthrough.shapes import Shape, Solid, names_of
from leadthrough.shapes.shape import pose

# The error that a measured or printed tensor may have, as a fraction of its largest moment.
_INERTIA_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False, init=False)
class Load(ShortRepr):
    mass: float  # in kg, >= 0
    center: Float64Array  # centre of mass (3,) in m
    inertia: Float64Array  # tensor (3, 3) about the centre of mass in kg m^2

    def __init__(self, mass: float, center: ArrayLike, inertia: ArrayLike) -> None:
        vars(self).update(
            mass=check.number(mass, "mass", at_least=0.0),
            center=check.frozen(center, "center", shape=(3,)),
            inertia=_inertia(inertia),
        )


@dataclass(frozen=True, eq=False, init=False)
class Attachment(ShortRepr):
    """All that is fixed to a link, in that link's frame."""

    position: Float64Array  # of the tip, (3,) in m
    orientation: Float64Array  # of the tip, (4,) w, x, y, z
    loads: tuple[Load, ...]  # the rigid bodies carried
    shapes: tuple[Shape, ...]  # the shapes of the objects held

    def __init__(
        self,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        loads: tuple[Load, ...] = (),
        shapes: tuple[Shape, ...] = (),
    ) -> None:
        vars(self).update(loads=loads, shapes=shapes, **pose(position, orientation))

    def summary(self) -> list[str]:
        """The tool, the mass and the shapes carried, in a few words each."""
        parts = [f"tool at {numbers_text(self.position)} m"] if self.position.any() else []
        mass = sum(load.mass for load in self.loads)
        parts += [f"carries {mass:.3g} kg"] if mass else []
        return parts + ([f"holds {len(self.shapes)} shapes"] if self.shapes else [])

    def with_tool(self, position: ArrayLike, orientation: ArrayLike) -> Attachment:
        """The attachment with the tip at a pose given in the frame of the present tip."""
        where = check.array(position, "position", shape=(3,))
        turn = check.quaternions(orientation, "orientation", shape=(4,))
        return replace(self, position=self._in_link(where), orientation=self._rotated(turn))

    def with_load(self, load: Load) -> Attachment:
        """The attachment with another load, given in the frame of the tip."""
        turn = self._rotation()
        moments = turn @ load.inertia @ turn.T
        return replace(
            self, loads=(*self.loads, Load(load.mass, self._in_link(load.center), moments))
        )

    def with_shape(self, shape: Solid, mass: float) -> Attachment:
        """The attachment with an object of uniform density, given in the frame of the tip."""
        if not isinstance(shape, Solid):
            raise InvalidInput(f"shape: expected a {names_of(Solid)}, got {shape!r}")
        weight = check.number(mass, "mass", at_least=0.0)
        center, inertia = shape.unit_inertia()
        carried = self if weight == 0.0 else self.with_load(Load(weight, center, weight * inertia))
        placed = shape.at(self._in_link(shape.position), self._rotated(shape.orientation))
        return replace(carried, shapes=(*self.shapes, placed))

    def applied_to(self, chain: core.Chain) -> core.Chain:
        """A chain that ends in the link, with the loads added and the tip moved."""
        for load in self.loads:
            chain = chain.with_load(load.mass, load.center, load.inertia)
        return chain.with_tool(self.position, self.orientation)

    def _rotation(self) -> Float64Array:
        return np.asarray(rotations.to_matrix(self.orientation[None])[0])

    def _in_link(self, point: Float64Array) -> Float64Array:
        return np.asarray(self.position + self._rotation() @ point)

    def _rotated(self, orientation: Float64Array) -> Float64Array:
        return np.asarray(rotations.compose(self.orientation[None], orientation[None])[0])


def _inertia(value: ArrayLike) -> Float64Array:
    """A tensor that a body can have: symmetric, no moment above the sum of the other two."""
    inertia = check.frozen(value, "inertia", shape=(3, 3))
    slack = _INERTIA_TOLERANCE * float(np.abs(inertia).max())
    if np.abs(inertia - inertia.T).max() > slack:
        raise InvalidInput(f"inertia: expected a symmetric matrix, got {inertia.tolist()}")
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] < -slack or moments[0] + moments[1] < moments[2] - slack:
        raise InvalidInput(
            "inertia: expected principal moments of a body, none negative and none above the sum "
            f"of the other two, got {moments.tolist()}"
        )
    return inertia
