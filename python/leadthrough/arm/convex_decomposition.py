"""Convex parts of a mesh, which contain its surface and its inside.

A mesh whose convex hull stands out is cut by a plane, and so are both sides. A part is the hull of
the triangles between its planes, clipped. At most two axes are normal to planes: along the third, a
line through a point inside a closed mesh meets the surface on both sides of the point and between
the same planes, so that the part contains the point.

Method: Lien and Amato 2007, with the planes that leave the least volume.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.shapes.convex_parts import MAX_GAP, clipped, hull_of

_MAX_CUTS = 3  # one after another, so that a mesh has eight parts at most
_MIN_GAIN = 0.02  # of a hull's volume, which a cut takes away
_PLACES = np.arange(1, 8) / 8  # of planes, in the part's extent
_TRIED = 2000  # triangles by which planes are compared
_Plane = tuple[int, float]  # the axis that is normal to it, and its place along that


def convex_parts(vertices: Float64Array, faces: NDArray[np.int64]) -> tuple[Float64Array, ...]:
    """Vertices (k, 3) of each part of a mesh in m; raises QhullError if it is flat."""
    from scipy.spatial import ConvexHull  # only robots with meshes need it

    whole = ConvexHull(vertices)
    hulls = _parts(vertices[faces], whole, frozenset()) if len(faces) else [whole]
    return tuple(hull.points[hull.vertices] for hull in hulls)


def _parts(triangles: Float64Array, hull: Any, axes: frozenset[int], cuts: int = 0) -> list[Any]:
    """The hulls of triangles (n, 3, 3), after `cuts` cuts normal to these axes."""
    if cuts == _MAX_CUTS or _gap(triangles, hull, min({0, 1, 2} - axes)) < MAX_GAP:
        return [hull]
    plane = _best_plane(triangles, axes if len(axes) == 2 else {0, 1, 2})
    sides = [_clipped(triangles, plane, side) for side in (-1.0, 1.0)]
    hulls = [hull_of(side) for side in sides]
    if _volume(hulls) > (1.0 - _MIN_GAIN) * hull.volume:
        return [hull]
    both = zip(sides, hulls, strict=True)
    return [part for each in both for part in _parts(*each, axes | {plane[0]}, cuts + 1)]


def _gap(triangles: Float64Array, hull: Any, axis: int) -> float:
    """The mean distance of the hull from the solid in it, which planes along this axis cut off."""
    a, b, c = triangles.transpose(1, 0, 2)
    six_volumes = np.cross(b - a, c - a)[:, axis] * (a + b + c)[:, axis]
    return float((hull.volume - abs(six_volumes.sum()) / 6.0) / hull.area)


def _best_plane(triangles: Float64Array, axes: frozenset[int] | set[int]) -> _Plane:
    """The plane beside which the hulls are the smallest."""
    some = triangles[:: len(triangles) // _TRIED + 1]
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    planes, volumes = [], []
    for axis in sorted(axes):
        slabs, rest = [], some
        for place in low[axis] + _PLACES * (high[axis] - low[axis]):
            planes.append((axis, place))
            slabs.append(_clipped(rest, planes[-1], -1.0))
            rest = _clipped(rest, planes[-1], 1.0)
        below, above = _volumes(slabs), _volumes([rest, *slabs[:0:-1]])
        volumes += [a + b for a, b in zip(below, reversed(above), strict=True)]
    return planes[int(np.argmin(volumes))]


def _volumes(slabs: list[Float64Array]) -> list[float]:
    """The volumes, approximately, of the hulls of the first slab, of the first two and so on."""
    directions = _directions()
    volumes, points = [], np.empty((0, 3))
    for slab in slabs:
        points = np.concatenate([points, slab.reshape(-1, 3)])
        if len(points) > 0:
            points = points[np.unique((points @ directions).argmax(axis=0))]
        volumes.append(_volume([hull_of(points)]))
    return volumes


def _directions() -> Float64Array:
    """Unit vectors (3, 64) that are evenly spread (Gonzalez 2010)."""
    turn, z = 2.399963229728653 * np.arange(64), np.arange(-63, 64, 2) / 64
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z])


def _clipped(triangles: Float64Array, plane: _Plane, side: float) -> Float64Array:
    axis, place = plane
    return clipped(triangles, np.eye(3)[axis], place, side)


def _volume(hulls: list[Any]) -> float:
    """The volume of hulls, infinite if one is flat."""
    return np.inf if None in hulls else sum(hull.volume for hull in hulls)
