"""Convex parts of a closed mesh: exact ones of flat faces, as of boards, boxes and brackets.

A solid is cut along the face with the most room between it and the hull, and so are both sides,
until every part is its own hull. A side is what the planes leave of the surface, and the corners
between planes that lie inside the mesh, told by its winding number (Jacobson et al. 2013). If
rounded edges would need too many planes, these lie a millimetre in front of the faces, so that one
serves several.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array

MAX_GAP = 0.002  # m, between a part and the surface in it
_SPARE = (0.0, 0.001)  # m, of planes before their faces: the first with which they are few
_MAX_PARTS = 64  # of curved surfaces there would be thousands
_MAX_PAIRS = 10_000_000  # of faces and of the hull's, which take 80 MB
_ROUNDING = 1e-7  # m
_AHEAD = 0.7  # cosine; a side of the hull farther around is beside a face and not before it
_INWARDS = 1e-5  # of the way from a corner to the middle of the corners
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)

_Faces = tuple[Float64Array, Float64Array, Float64Array]


def divided(vertices: Float64Array, faces: NDArray[np.int64]) -> list[Float64Array]:
    """Vertices (k, 3) of each part of a mesh; none if it is not closed or would need too many."""
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]  # the others are lines
    if len(faces) == 0 or not _is_closed(faces):
        return []
    solid = vertices[faces]
    if np.linalg.det(solid).sum() < 0.0:
        solid = solid[:, ::-1]
    whole = hull_of(vertices)
    if whole is None or len(faces) * len(whole.equations) > _MAX_PAIRS:
        return []
    deep = _deep_faces(solid, whole)
    tries = (_parts(solid, spare) for spare in _SPARE if _plane_count(solid, deep, spare) > 0)
    return next(filter(None, tries), [])


def _plane_count(solid: Float64Array, deep: _Faces, spare: float) -> int:
    """The number of planes, one at least, that lie along all deep faces; 0 of too many."""
    normals, places, volumes = deep
    for count in range(1, 2 * _MAX_PARTS):  # not all are needed: cuts leave less room before others
        face = int(np.argmax(volumes))
        away = np.abs(solid @ normals[face] - places[face]).max(axis=1)
        volumes = np.where(away > spare + _ROUNDING, volumes, 0.0)
        if not volumes.any():
            return count
    return 0


def _parts(solid: Float64Array, spare: float) -> list[Float64Array]:
    corners = solid.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    left, parts = [(solid, low + _CORNERS * (high - low))], list[Float64Array]()
    while left:
        if len(left) + len(parts) > _MAX_PARTS:
            return []
        surface, corners = left.pop()
        points = np.concatenate([surface.reshape(-1, 3), _inside(corners, solid)])
        hull = hull_of(points)
        face = None if hull is None else _deepest_face(surface, hull)
        if face is None:
            if len(points) > 0:
                parts.append(points if hull is None else hull.points[hull.vertices])
            continue
        around, plane = hull_of(corners), (face[0], face[1] + spare)
        box = around.points[around.simplices]
        for side in (-1.0, 1.0):
            ends = np.unique(clipped(box, *plane, side).reshape(-1, 3), axis=0)
            left.append((clipped(surface, *plane, side), ends))
    return parts


def _is_closed(faces: NDArray[np.int64]) -> bool:
    """Whether each edge has a face on both sides, which turn the same way."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forth, back = (np.unique(each, axis=0) for each in (edges, edges[:, ::-1]))
    return len(forth) == len(edges) and np.array_equal(forth, back)


def _deepest_face(surface: Float64Array, hull: Any) -> tuple[Float64Array, float] | None:
    """Normal and place of the face with the most volume between it and the hull; None without."""
    if len(surface) == 0:
        return None
    normals, places, volumes = _deep_faces(surface, hull)
    face = int(np.argmax(volumes))
    return (normals[face], float(places[face])) if volumes[face] > 0.0 else None


def _deep_faces(surface: Float64Array, hull: Any) -> _Faces:
    """Normals (n, 3) and places (n,) of faces, and the volumes (n,) between them and the hull."""
    a, b, c = surface.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas, np.finfo(np.float64).tiny)[:, None]
    middles = surface.mean(axis=1)
    rates = normals @ hull.equations[:, :3].T
    extent, depths = np.ptp(hull.points, axis=0).max(), np.zeros(len(surface))
    for points in (middles, a, b, c):
        gaps = -(points @ hull.equations[:, :3].T + hull.equations[:, 3])
        ahead = np.divide(gaps, rates, out=np.full_like(gaps, extent), where=rates > _AHEAD)
        depths = np.maximum(depths, ahead.min(axis=1))
    depths[depths <= MAX_GAP] = 0.0
    return normals, (normals * middles).sum(axis=1), 0.5 * depths * areas


def _inside(corners: Float64Array, solid: Float64Array) -> Float64Array:
    """Those of the corners (k, 3) beside which is the inside of a closed mesh."""
    # On the surface itself the winding number is none.
    beside = corners + _INWARDS * (corners.mean(axis=0) - corners)
    return corners[[_winding(solid - point) > 0.5 for point in beside]]


def _winding(triangles: Float64Array) -> float:
    """How often triangles (n, 3, 3) wind around the origin (Van Oosterom and Strackee 1983)."""
    a, b, c = triangles.transpose(1, 0, 2)
    at_a, at_b, at_c = np.sqrt(np.einsum("nki,nki->kn", triangles, triangles))
    ab, bc, ca = (np.einsum("ni,ni->n", *pair) for pair in ((a, b), (b, c), (c, a)))
    below = at_a * at_b * at_c + ab * at_c + bc * at_a + ca * at_b
    volumes = np.einsum("ni,ni->n", a, np.cross(b, c))
    return float(np.arctan2(volumes, below).sum() / (2.0 * np.pi))


def clipped(
    triangles: Float64Array, normal: Float64Array, place: float, side: float
) -> Float64Array:
    """The triangles (n, 3, 3) on a side of a plane; those that it cuts, their pieces there.

    Those in the plane are on the side behind them.
    """
    heights = side * (triangles @ normal - place)
    heights[np.abs(heights) < _ROUNDING] = 0.0
    a, b, c = triangles.transpose(1, 0, 2)
    behind = side * (np.cross(b - a, c - a) @ normal) < 0.0
    inside = heights > 0.0
    counts, cut = inside.sum(axis=1), (heights < 0.0).any(axis=1)
    pieces = [triangles[~cut & ((counts > 0) | behind)]]
    for count in (1, 2):
        crossed = cut & (counts == count)
        some, height = triangles[crossed], heights[crossed]
        alone = np.argmax(inside[crossed] == (count == 1), axis=1)
        order = (alone[:, None] + np.arange(3)) % 3  # its vertex on a side of its own is the first
        a, b, c = np.take_along_axis(some, order[:, :, None], axis=1).transpose(1, 0, 2)
        at_a, at_b, at_c = np.take_along_axis(height, order, axis=1).T[:, :, None]
        ab, ac = a + at_a / (at_a - at_b) * (b - a), a + at_a / (at_a - at_c) * (c - a)
        found = [(a, ab, ac)] if count == 1 else [(ab, b, c), (ab, c, ac)]
        pieces += [np.stack(corners, axis=1) for corners in found]
    return np.concatenate(pieces)


def hull_of(corners: Float64Array) -> Any:
    """The convex hull of the corners (..., 3) of triangles, or None if they are flat."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(corners.reshape(-1, 3))
    except (QhullError, ValueError):  # the latter without a triangle
        return None
