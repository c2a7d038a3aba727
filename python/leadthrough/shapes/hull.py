"""Convex hulls of the connected parts of a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr

MOST_PARTS = 1000  # each is checked against every link
# A part that is thinner, m, is given the thickness of a sheet: without any it has no inside.
_THIN, _SHEET = 1e-4, 1e-3


@dataclass(frozen=True, eq=False)
class Hull(ShortRepr):
    """A convex polyhedron.

    Attributes:
        vertices: its corners (n, 3), m.
        faces: indices of vertices (m, 3), anticlockwise as seen from outside.
    """

    vertices: Float64Array
    faces: NDArray[np.int64]


def hulls_of_parts(vertices: Float64Array, faces: NDArray[np.int64]) -> tuple[Hull, ...]:
    """The convex hull of each connected part of a mesh, in the order of their first vertices."""
    return tuple(_hull(part) for part in _parts(vertices, faces))


def _parts(vertices: Float64Array, faces: NDArray[np.int64]) -> list[Float64Array]:
    """Vertices (k, 3) of each part."""
    # Only meshes need it, and it takes long to load.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    places, own = np.unique(vertices, axis=0, return_inverse=True)
    corners = own.ravel()[faces]
    edges = np.concatenate([corners[:, :2], corners[:, 1:]]).T
    links = coo_array((np.ones(edges.shape[1], np.int8), tuple(edges)), shape=(len(places),) * 2)
    _, labels = connected_components(links, directed=False)
    used = np.unique(corners)
    order = used[np.argsort(labels[used], kind="stable")]
    starts = np.flatnonzero(np.diff(labels[order])) + 1
    if len(starts) >= MOST_PARTS:
        raise InvalidInput(
            f"faces: expected at most {MOST_PARTS:,} connected parts, got {len(starts) + 1:,}; "
            "leave small parts out, or give the vertices as a PointCloud"
        )
    return np.split(places[order], starts)


def _hull(points: Float64Array) -> Hull:
    from scipy.spatial import ConvexHull, QhullError

    solid = _with_thickness(points)
    try:
        found = ConvexHull(solid)
    except QhullError:
        size = float(np.ptp(points, axis=0).max())
        raise InvalidInput(
            f"vertices: a part of {size:.3g} m is too thin for its size; leave it out or thicken it"
        ) from None
    kept = found.vertices
    number = np.zeros(len(solid), dtype=np.int64)
    number[kept] = np.arange(len(kept))
    a, b, c = (solid[found.simplices[:, k]] for k in range(3))
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) > 0.0
    faces = np.where(outwards[:, None], found.simplices, found.simplices[:, ::-1])
    return Hull(solid[kept], number[faces])


def _with_thickness(points: Float64Array) -> Float64Array:
    """The points, and where they are flat, those of a sheet around them."""
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh((points - middle).T @ (points - middle))
    for axis, extent in zip(axes.T, np.ptp((points - middle) @ axes, axis=0), strict=True):
        if extent < _THIN:
            aside = 0.5 * _SHEET * axis
            points = np.concatenate([points - aside, points + aside])
    return points
