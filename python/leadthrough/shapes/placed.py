"""What all shapes have in common: a place, and an answer to the compiled core."""

from __future__ import annotations

from abc import ABC, abstractmethod
from copy import copy
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr

UNTURNED = (1.0, 0.0, 0.0, 0.0)
_FARTHEST = 1e6  # m; beyond, rounding would eat what is thin


class Placed(ShortRepr, ABC):
    """A shape at a place."""

    position: Float64Array

    @property
    def middle(self) -> Float64Array:
        """Centre (3,), m, of the ball and of the box that bound it, in the base frame."""
        return self.position

    def at(self, position: ArrayLike, orientation: ArrayLike | None = None) -> Self:
        """The same shape at another pose.

        Args:
            position: (3,), m in the base frame.
            orientation: (4,) w, x, y, z; by default as before. A sphere has none and ignores it.

        Raises:
            InvalidInput: if one of them is malformed.
        """
        here = pose(position, UNTURNED if orientation is None else orientation)
        if orientation is None:
            del here["orientation"]
        moved = copy(self)
        vars(moved).update((name, here[name]) for name in here if name in vars(self))
        return moved

    def distance(self, points: ArrayLike) -> Float64Array:
        """Signed distances (n,) of points, m; of several parts, to the nearest or deepest one.

        Args:
            points: m in the base frame, (n, 3).

        Raises:
            InvalidInput: if they are not finite points of that shape.
        """
        return self._compiled.distances(check.array(points, "points", shape=("n", 3)))

    @cached_property
    def _compiled(self) -> _core.Shape:
        """The shape as the compiled core takes it."""
        return self._compile()

    @abstractmethod
    def _compile(self) -> _core.Shape:
        """The shape for the compiled core, made anew."""

    def __getstate__(self) -> dict[str, Any]:  # what is cached is made again
        fields = self.__dataclass_fields__  # type: ignore[attr-defined]
        return {name: value for name, value in vars(self).items() if name in fields}


class Turned(Placed):
    """A shape at a place that may be turned."""

    orientation: Float64Array

    @cached_property
    def _matrix(self) -> Float64Array:
        """The rotation (3, 3) from the shape's own frame to the base's."""
        return np.asarray(rotations.to_matrix(self.orientation[None])[0])


class Bounded(Turned):
    """A shape that is known by points: its corners, or the centres of its balls."""

    @property
    def middle(self) -> Float64Array:
        """Centre (3,), m, of the ball and of the box that bound it, in the base frame."""
        lower, upper = self._corners
        return 0.5 * (lower + upper)

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        lower, upper = self._corners
        return 0.5 * (upper - lower) + self._rounding

    @cached_property
    def bounding_radius(self) -> float:
        """Radius of the ball around its middle that contains it, m."""
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
        """How far the shape reaches around its points, m."""
        return 0.0


def pose(position: ArrayLike, orientation: ArrayLike) -> dict[str, Float64Array]:
    """A position (3,) and a unit quaternion (4,), read-only, by their names."""
    centre = check.frozen(position, "position", shape=(3,))
    quaternion = check.quaternions(orientation, "orientation", shape=(4,))
    quaternion.setflags(write=False)
    return {"position": centre, "orientation": quaternion}


def places(value: ArrayLike, name: str) -> Float64Array:
    """Points (n, 3), read-only, near enough to the origin to be measured."""
    points = check.frozen(value, name, shape=("n", 3))
    farthest = float(np.abs(points).max(initial=0.0))
    if farthest > _FARTHEST:
        raise InvalidInput(f"{name}: expected places within {_FARTHEST:g} m, got {farthest:.3g} m")
    return points


def length(vectors: Float64Array) -> Float64Array:
    """Lengths (n,) of vectors (n, 3), many times faster than NumPy's reduction over three."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))
