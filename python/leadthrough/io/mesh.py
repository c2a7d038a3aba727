"""Mesh files: STL and OBJ are read here, other formats through the extra `mesh`."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from leadthrough import optional
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io import bounds

_Mesh = tuple[Float64Array, NDArray[np.int64]]

_STL_HEADER = 84  # bytes, the last four the number of triangles
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_vertices(path: Path) -> Float64Array:
    """All vertices (n, 3) of a mesh, repeated ones included, in the file's unit.

    Args:
        path: mesh file.

    Raises:
        InvalidInput: if the file cannot be read.
        MissingDependency: if its format needs the extra `mesh`.
    """
    return _read(path)[0]


def read_triangles(path: Path) -> tuple[Float64Array, NDArray[np.int64]]:
    """Vertices (n, 3) of a mesh, in the file's unit, and vertex indices (m, 3) of its triangles.

    A polygon becomes a fan of triangles.

    Args:
        path: mesh file.

    Raises:
        InvalidInput: if the file cannot be read or has no valid triangles.
        MissingDependency: if its format needs the extra `mesh`.
    """
    vertices, faces = _read(path)
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(vertices):
        raise InvalidInput(f"{path}: expected triangles between the mesh's own vertices")
    return vertices, faces


def _read(path: Path) -> _Mesh:
    try:
        with bounds.reading("mesh", damage=(OSError, ValueError, RuntimeError)):
            match path.suffix.lower():
                case ".stl":
                    mesh = _stl(path.read_bytes())
                case ".obj":
                    mesh = _obj(path.read_bytes())
                case _:
                    mesh = _through_coal(path)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None
    if len(mesh[0]) == 0 or not np.isfinite(mesh[0]).all():
        raise InvalidInput(f"{path}: expected a mesh of finite vertices")
    return mesh


def _stl(content: bytes) -> _Mesh:
    # A binary file may begin with "solid" like a text; its length tells which it is.
    triangles = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if len(content) != _STL_HEADER + triangles * _STL_TRIANGLE.itemsize:
        vertices = _after_word(content, b"vertex")
    else:
        body = np.frombuffer(content, _STL_TRIANGLE, offset=_STL_HEADER)
        vertices = body["corners"].reshape(-1, 3).astype(np.float64)
    whole = len(vertices) - len(vertices) % 3
    return vertices, np.arange(whole).reshape(-1, 3)


def _obj(content: bytes) -> _Mesh:
    vertices = _after_word(content, b"v")
    faces = []
    for line in content.splitlines():
        word, *corners = line.split() or [b""]
        if word == b"f":
            # Vertex, texture and normal by slashes; negative numbers count from the end.
            numbers = [int(corner.split(b"/")[0]) for corner in corners]
            polygon = [n - 1 if n > 0 else n + len(vertices) for n in numbers]
            faces += [(polygon[0], b, c) for b, c in pairwise(polygon[1:])]
    return vertices, np.array(faces, dtype=np.int64).reshape(-1, 3)


def _after_word(content: bytes, word: bytes) -> Float64Array:
    lines = (line.split() for line in content.splitlines())
    rows = [line[1:4] for line in lines if line and line[0] == word]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _through_coal(path: Path) -> _Mesh:
    coal = optional.load("coal", extra="mesh")
    mesh = coal.MeshLoader().load(str(path), np.ones(3))
    faces = [[mesh.tri_indices(i)[k] for k in range(3)] for i in range(mesh.num_tris)]
    return np.array(mesh.vertices()), np.array(faces, dtype=np.int64).reshape(-1, 3)
