"""Meshes, replaced by convex parts, and point clouds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.shapes import surface
from leadthrough.shapes.convex_parts import divided
from leadthrough.shapes.shape import IDENTITY, ConvexPart, PointBased, Solid, checked_points, pose
from leadthrough.shapes.surface import Surface, merged

MAX_PARTS = 1000  # each is checked against every link
# A part that is thinner, m, is given the thickness of a sheet: without any it has no inside.
_THIN, _SHEET = 1e-4, 1e-3


@dataclass(frozen=True, eq=False, init=False)
class Mesh(PointBased, Solid):
    """A surface of triangles, which counts as convex parts.

    Closed surfaces of faces that are flat, or rounded at edges, such as shelves, bins and brackets,
    are divided into parts that fill them to 3 mm. Of curved and of open ones each connected part
    counts as its convex hull: the free space inside counts as occupied. The parts contain the
    surface, so that no collision is missed; those thinner than a tenth of a millimetre count as
    1 mm thick.

    Attributes:
        vertices: (n, 3), m in the mesh's own frame.
        faces: indices of vertices (m, 3), m > 0; vertices at the same place are one.
        position: of the mesh's frame in the base frame, (3,), m; by default its origin.
        orientation: w, x, y, z of the mesh's frame in the base frame, (4,); by default the same.
        parts: the convex parts, in the mesh's own frame.

    Raises:
        InvalidInput: if a part is too thin for its size, or there are more than a thousand parts.
    """

    vertices: Float64Array
    faces: NDArray[np.int64]
    position: Float64Array
    orientation: Float64Array
    parts: tuple[Surface, ...] = field(init=False)

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = IDENTITY,
    ) -> None:
        corners = checked_points(vertices, "vertices")
        triangles = _triangles(faces, len(corners))
        vars(self).update(
            vertices=corners,
            faces=triangles,
            **pose(position, orientation),
            parts=check.freeze(tuple(map(hull, _parts(*_merged(corners, triangles))))),
        )

    def surface(self) -> Surface:
        return merged(self.parts)

    def convex_parts(self) -> Iterator[ConvexPart]:
        for part in self.parts:
            yield ConvexPart("mesh", (), self.position, self.orientation, part.vertices)

    def unit_inertia(self) -> tuple[Float64Array, Float64Array]:
        _, centre, spread = self.surface().moments()
        inertia = np.trace(spread) * np.eye(3) - spread
        return self.position + self._rotation @ centre, self._rotation @ inertia @ self._rotation.T

    def _outline(self) -> Float64Array:
        corners = np.concatenate([part.vertices for part in self.parts])
        return np.asarray(corners @ self._rotation.T + self.position)

    def _compile(self) -> core.Shape:
        hulls = [part.vertices for part in self.parts]
        return core.hulls_shape(hulls, self.position, self.orientation)


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
    return check.freeze(whole)


def _merged(
    vertices: Float64Array, faces: NDArray[np.int64]
) -> tuple[Float64Array, NDArray[np.int64]]:
    """The vertices that faces use, each place once, and the faces."""
    unique, own = np.unique(vertices[faces].reshape(-1, 3), axis=0, return_inverse=True)
    return unique, own.reshape(-1, 3)


def _parts(vertices: Float64Array, faces: NDArray[np.int64]) -> list[Float64Array]:
    """Vertices (k, 3) of the convex parts of each connected one."""
    # Only meshes need it, and it takes long to load.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges = np.concatenate([faces[:, :2], faces[:, 1:]]).T
    links = coo_array((np.ones(edges.shape[1], np.int8), tuple(edges)), shape=(len(vertices),) * 2)
    count, labels = connected_components(links, directed=False)
    if count > MAX_PARTS:
        raise InvalidInput(
            f"faces: expected at most {MAX_PARTS:,} connected parts, got {count:,}; "
            "leave small parts out, or give the vertices as a PointCloud"
        )
    order = np.argsort(labels[faces[:, 0]], kind="stable")
    starts = np.flatnonzero(np.diff(labels[faces[order, 0]])) + 1
    connected = [_merged(vertices, each) for each in np.split(faces[order], starts)]
    parts = [part for each in connected for part in divided(*each) or [each[0]]]
    return parts if len(parts) <= MAX_PARTS else [own for own, _ in connected]


def hull(points: Float64Array) -> Surface:
    from scipy.spatial import ConvexHull, QhullError

    solid = _with_thickness(points)
    try:
        hull = ConvexHull(solid)
    except QhullError:
        size = float(np.ptp(points, axis=0).max())
        raise InvalidInput(
            f"vertices: a part of {size:.3g} m is too thin for its size; leave it out or thicken it"
        ) from None
    corners = hull.vertices
    number = np.zeros(len(solid), dtype=np.int64)
    number[corners] = np.arange(len(corners))
    a, b, c = (solid[hull.simplices[:, k]] for k in range(3))
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) > 0.0
    faces = np.where(outwards[:, None], hull.simplices, hull.simplices[:, ::-1])
    return Surface(solid[corners], number[faces])


def _with_thickness(points: Float64Array) -> Float64Array:
    """The points, and where they are flat, those of a sheet around them."""
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh((points - middle).T @ (points - middle))
    for axis, extent in zip(axes.T, np.ptp((points - middle) @ axes, axis=0), strict=True):
        if extent < _THIN:
            aside = 0.5 * _SHEET * axis
            points = np.concatenate([points - aside, points + aside])
    return points


MAX_POINTS = 1_000_000  # their tree takes 100 MB


@dataclass(frozen=True, eq=False, init=False)
class PointCloud(PointBased):
    """Balls of one radius around points.

    The balls stand for what lies between the points too: a radius of half the points' spacing, with
    the noise of their measurement added, leaves no holes. They are kept in a tree, so that a check
    of ten thousand takes microseconds.

    Attributes:
        points: (n, 3), n > 0, m in the cloud's own frame.
        radius: of each ball, m, > 0.
        position: of the cloud's frame in the base frame, (3,), m; by default its origin.
        orientation: w, x, y, z of the cloud's frame in the base frame, (4,); by default the
            same.

    Raises:
        InvalidInput: if there are no points or more than a million.
    """

    points: Float64Array
    radius: float
    position: Float64Array
    orientation: Float64Array

    def __init__(
        self,
        points: ArrayLike,
        radius: float,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = IDENTITY,
    ) -> None:
        seen = checked_points(points, "points")
        if not 0 < len(seen) <= MAX_POINTS:
            raise InvalidInput(
                f"points: expected 1 to {MAX_POINTS:,} points, got {len(seen):,}"
                + ("; keep one point per cube of the radius" if len(seen) else "")
            )
        vars(self).update(
            points=seen,
            radius=check.number(radius, "radius", above=0.0),
            **pose(position, orientation),
        )

    def surface(self) -> Surface:
        return surface.dots(self.points, self.radius)

    def convex_parts(self) -> Iterator[ConvexPart]:
        for point in self._outline():
            yield ConvexPart("sphere", (self.radius,), point, np.array(IDENTITY))

    def _outline(self) -> Float64Array:
        return np.asarray(self.points @ self._rotation.T + self.position)

    @property
    def _rounding(self) -> float:
        return self.radius

    def _compile(self) -> core.Shape:
        return core.cloud_shape(self.points, self.radius, self.position, self.orientation)
