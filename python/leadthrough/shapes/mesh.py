"""Meshes, each connected part of which counts as its convex hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.shapes.hull import Hull, hulls_of_parts
from leadthrough.shapes.placed import UNTURNED, Bounded, places, pose


@dataclass(frozen=True, eq=False, init=False)
class Mesh(Bounded):
    """A surface of triangles, of which each connected part counts as its convex hull.

    The hulls contain the surface, so that no collision is missed, and the free space inside a
    hollow part counts as occupied: a shelf that is modelled as separate boards stays open, one that
    is a single surface does not. What is thinner than a tenth of a millimetre counts as 1 mm thick.

    Attributes:
        vertices: (n, 3), m in the mesh's own frame.
        faces: indices of vertices (m, 3), m > 0; vertices at the same place are one.
        position: of the mesh's frame in the base frame, (3,), m; by default its origin.
        orientation: w, x, y, z of the mesh's frame in the base frame, (4,); by default the same.
        parts: the hulls, in the mesh's own frame.

    Raises:
        InvalidInput: if one of them is malformed, a part is too thin for its size, or there are
            more than a thousand parts.
    """

    vertices: Float64Array
    faces: NDArray[np.int64]
    position: Float64Array
    orientation: Float64Array
    parts: tuple[Hull, ...]

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = UNTURNED,
    ) -> None:
        corners = places(vertices, "vertices")
        triangles = _triangles(faces, len(corners))
        vars(self).update(
            vertices=corners,
            faces=triangles,
            **pose(position, orientation),
            parts=hulls_of_parts(corners, triangles),
        )

    def _outline(self) -> Float64Array:
        corners = np.concatenate([part.vertices for part in self.parts])
        return np.asarray(corners @ self._matrix.T + self.position)

    def _compile(self) -> _core.Shape:
        hulls = [part.vertices for part in self.parts]
        return _core.hulls_shape(hulls, self.position, self.orientation)


def _triangles(faces: ArrayLike, vertices: int) -> NDArray[np.int64]:
    """Indices (m, 3), m > 0, read-only."""
    given = check.array(faces, "faces", shape=("m", 3))
    whole = given.astype(np.int64)
    if len(whole) == 0 or (whole != given).any():
        raise InvalidInput("faces: expected whole numbers (m, 3), m > 0, each naming a vertex")
    if whole.min() < 0 or whole.max() >= vertices:
        raise InvalidInput(
            f"faces: expected indices 0 to {vertices - 1}, got {whole.min()} to {whole.max()}"
        )
    whole.setflags(write=False)
    return whole
