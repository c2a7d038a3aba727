"""Boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.shapes.placed import UNTURNED, Turned, pose


@dataclass(frozen=True, eq=False, init=False)
class Box(Turned):
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

    def __init__(
        self, size: ArrayLike, position: ArrayLike, orientation: ArrayLike = UNTURNED
    ) -> None:
        edges = check.frozen(size, "size", shape=(3,))
        for edge in edges:
            check.number(edge, "size", above=0.0)
        vars(self).update(size=edges, **pose(position, orientation))

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around its position that contains it, m."""
        return float(0.5 * np.linalg.norm(self.size))

    @property
    def half_extents(self) -> Float64Array:
        """Half the edges (3,), m, of its bounding box parallel to the base's axes."""
        return np.asarray(np.abs(self._matrix) @ (0.5 * self.size))

    def _compile(self) -> _core.Shape:
        return _core.box_shape(self.size, self.position, self.orientation)
