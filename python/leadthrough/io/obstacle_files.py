"""Obstacles from files: meshes of things, and points that a camera or a scanner has seen."""

from __future__ import annotations

from pathlib import Path

from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.io.atomic import StrPath
from leadthrough.io.mesh import read_triangles
from leadthrough.io.points import read_points
from leadthrough.shapes import Mesh, PointCloud

_ORIGIN = (0.0, 0.0, 0.0)
_UNTURNED = (1.0, 0.0, 0.0, 0.0)


def read_mesh(
    path: StrPath,
    *,
    scale: float = 1.0,
    position: ArrayLike = _ORIGIN,
    orientation: ArrayLike = _UNTURNED,
) -> Mesh:
    """The mesh of a file as an obstacle: each connected part counts as its convex hull.

    Args:
        path: an STL or OBJ file; others, as COLLADA, with the extra `mesh`.
        scale: m per unit of the file, > 0: 0.001 for millimetres.
        position: of the mesh's own frame in the base frame, (3,), m.
        orientation: w, x, y, z of the mesh's own frame in the base frame, (4,).

    Raises:
        InvalidInput: if the file cannot be read or has no triangles, there are more than a thousand
            parts, or an argument is out of its range.
        MissingDependency: if its format needs the extra `mesh`.
    """
    unit = check.number(scale, "scale", above=0.0)
    vertices, faces = read_triangles(Path(path))
    return Mesh(unit * vertices, faces, position, orientation)


def read_point_cloud(
    path: StrPath,
    radius: float,
    *,
    scale: float = 1.0,
    position: ArrayLike = _ORIGIN,
    orientation: ArrayLike = _UNTURNED,
) -> PointCloud:
    """The points of a file as an obstacle: a ball around each.

    Args:
        path: a file .pcd, .ply, .npy, .csv, .txt or .xyz, with columns x, y and z; points that
            were not seen (NaN) are left out.
        radius: of the balls, m, > 0.
        scale: m per unit of the file, > 0: 0.001 for millimetres.
        position: of the camera's or the cloud's own frame in the base frame, (3,), m.
        orientation: w, x, y, z of that frame in the base frame, (4,).

    Raises:
        InvalidInput: if the file cannot be read or has no points or too many, or an argument is
            out of its range.
    """
    unit = check.number(scale, "scale", above=0.0)
    return PointCloud(unit * read_points(Path(path)), radius, position, orientation)
