"""Vertex normals of a mesh that is smooth except at creases."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.shapes.surface import Surface

# Faces that meet at a smaller angle belong to one curved surface.
_CREASE = np.radians(35.0)
# Corners of different triangles nearer than this fraction of the mesh's extent are one point.
_WELD = 1e-6


def creased(mesh: Surface) -> tuple[Surface, Float64Array]:
    """The mesh with separate vertices on both sides of creases, and unit normals (n, 3)."""
    corners = mesh.vertices[mesh.faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    flat = np.divide(areas, lengths, out=np.zeros_like(areas), where=lengths > 0.0)
    points = _welded(mesh)[mesh.faces].ravel()
    face_of = np.repeat(np.arange(len(mesh.faces)), 3)
    normals = _around(points, flat[face_of], areas[face_of])
    keys = np.column_stack([points, np.round(normals * 1e3).astype(np.int64)])
    _, first, faces = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    vertices = mesh.vertices[mesh.faces.ravel()[first]]
    return Surface(vertices, faces.reshape(-1, 3)), normals[first]


def _welded(mesh: Surface) -> NDArray[np.int64]:
    """A number (n,) for each vertex, the same for vertices at the same place."""
    grain = _WELD * max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-9)
    cells = np.round(mesh.vertices / grain).astype(np.int64)
    return np.unique(cells, axis=0, return_inverse=True)[1].ravel()


def _around(points: NDArray[np.int64], flat: Float64Array, areas: Float64Array) -> Float64Array:
    """For each corner, the mean normal of the faces at its point that are turned almost alike."""
    order = np.argsort(points, kind="stable")
    starts = np.searchsorted(points[order], points)
    counts = np.bincount(points)[points]
    mine = np.repeat(np.arange(len(points)), counts)
    within = np.arange(len(mine)) - np.repeat(np.cumsum(counts) - counts, counts)
    other = order[starts[mine] + within]
    near = np.einsum("ij,ij->i", flat[mine], flat[other]) > np.cos(_CREASE)
    sums = np.zeros_like(flat)
    for axis in range(3):
        sums[:, axis] = np.bincount(
            mine[near], weights=areas[other[near], axis], minlength=len(points)
        )
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    upwards = np.tile([0.0, 0.0, 1.0], (len(sums), 1))
    return np.asarray(np.divide(sums, lengths, out=upwards, where=lengths > 0.0))
