"""Convex parts of a mesh whose faces are flat: exact ones, as of boards, boxes and brackets.

A solid is cut along the face with the most room between it and the hull, and so are both sides,
until every part is its own hull. A side is what the planes leave of the surface, and the corners
between planes that lie inside the mesh, told by its winding number (Jacobson et al. 2013).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array

MAX_GAP = 0.002  # m, between a part and the surface in it
_MAX_PARTS, _MAX_FACES = 64, 2000  # of curved surfaces there would be thousands
_ROUNDING = 1e-7  # m
_INWARDS = 1e-5  # of the way from a corner to the middle of the corners
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)


def exact_parts(vertices: Float64Array, faces: NDArray[np.int64]) -> list[Float64Array]:
    """Vertices (k, 3) of each part of a mesh; of one that is curved or not closed, none."""
    if len(faces) > _MAX_FACES or not _is_closed(faces):
        return []
    solid = vertices[faces]
    if np.linalg.det(solid).sum() < 0.0:
        solid = solid[:, ::-1]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    left, parts = [(solid, low + _CORNERS * (high - low))], list[Float64Array]()
    while left:
        if len(left) + len(parts) > _MAX_PARTS:
            return []
        surface, corners = left.pop()
        hull = hull_of(np.concatenate([surface.reshape(-1, 3), _inside(corners, solid)]))
        if hull is None:
            continue
        plane = _deepest_face(surface, hull)
        if plane is None:
            parts.append(hull.points[hull.vertices])
        else:
            around = hull_of(corners)
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
    a, b, c = surface.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas, np.finfo(np.float64).tiny)[:, None]
    middles = surface.mean(axis=1)
    rates = normals @ hull.equations[:, :3].T
    gaps = -(middles @ hull.equations[:, :3].T + hull.equations[:, 3])
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.where(rates > _ROUNDING, gaps / rates, np.inf).min(axis=1)
    depths[~((depths > MAX_GAP) & (depths < np.inf))] = 0.0
    face = int(np.argmax(depths * areas))
    return (normals[face], float(normals[face] @ middles[face])) if depths[face] > 0.0 else None


def _inside(corners: Float64Array, solid: Float64Array) -> Float64Array:
    """Those of the corners (k, 3) beside which is the inside of a closed mesh."""
    # On the surface itself the winding number is none.
    beside = corners + _INWARDS * (corners.mean(axis=0) - corners)
    return corners[[_winding(solid - point) > 0.5 for point in beside]]


def _winding(triangles: Float64Array) -> float:
    """How often triangles (n, 3, 3) wind around the origin (Van Oosterom and Strackee 1983)."""
    a, b, c = triangles.transpose(1, 0, 2)
    at_a, at_b, at_c = np.linalg.norm(triangles, axis=2).T
    below = at_a * at_b * at_c
    below += (a * b).sum(axis=1) * at_c + (b * c).sum(axis=1) * at_a + (c * a).sum(axis=1) * at_b
    return float(np.arctan2(np.linalg.det(triangles), below).sum() / (2.0 * np.pi))


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
