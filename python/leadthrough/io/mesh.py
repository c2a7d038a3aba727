"""Mesh files: STL and OBJ are read here, other formats through the extra `mesh`."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io import reader_process
from leadthrough.io.files import ReadLimits, StrPath, checked_path, read_bytes, refusing_damage
from leadthrough.shapes import Mesh

_Triangles = tuple[Float64Array, NDArray[np.int64]]

_STL_HEADER = 84  # bytes, the last four the number of triangles
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_mesh(
    path: StrPath,
    *,
    scale: float = 1.0,
    position: ArrayLike = (0.0, 0.0, 0.0),
    orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> Mesh:
    """The mesh of a file as an obstacle, which counts as convex parts.

    Args:
        path: an STL or OBJ file; others, as COLLADA, with the extra `mesh`.
        scale: m per unit of the file, > 0: 0.001 for millimetres.
        position: of the mesh's own frame in the base frame, (3,), m.
        orientation: w, x, y, z of the mesh's own frame in the base frame, (4,).

    Raises:
        InvalidInput: if the file cannot be read, has no triangles or more than a thousand parts.
        MissingDependency: if its format needs the extra `mesh`.
    """
    unit = check.number(scale, "scale", above=0.0)
    vertices, faces = read_triangles(checked_path(path))
    return Mesh(unit * vertices, faces, position, orientation)


def read_triangles(path: Path) -> _Triangles:
    """Vertices (n, 3) of a mesh, in the file's unit, and vertex indices (m, 3) of its triangles."""
    vertices, faces = read_vertices(path)
    if len(faces) == 0:
        raise InvalidInput(f"{path}: expected triangles")
    return vertices, faces


def read_vertices(path: Path) -> _Triangles:
    """All vertices of a mesh and the triangles, of which there may be none."""
    limits = ReadLimits()
    damage = (OSError, ValueError, OverflowError, RuntimeError)
    with check.prefixed(path), refusing_damage("mesh", damage=damage):
        match path.suffix.lower():
            case ".stl":
                mesh = _stl(read_bytes(path, limits), limits)
            case ".obj":
                mesh = _obj(read_bytes(path, limits), limits)
            case _:
                reader_process.require("coal", extra="mesh")
                mesh = reader_process.mesh(through_coal, path)
    vertices, faces = mesh
    if len(vertices) == 0 or not np.isfinite(vertices).all():
        raise InvalidInput(f"{path}: expected a mesh of finite vertices")
    if faces.min(initial=0) < 0 or faces.max(initial=-1) >= len(vertices):
        raise InvalidInput(f"{path}: expected triangles between the mesh's own vertices")
    return mesh


def _stl(content: bytes, limits: ReadLimits) -> _Triangles:
    # A binary file may begin with "solid" like a text; its length tells which it is.
    triangles = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if len(content) != _STL_HEADER + triangles * _STL_TRIANGLE.itemsize:
        vertices = _after_word(content, b"vertex", limits)
    else:
        limits.numbers(9 * triangles, "the triangles")
        body = np.frombuffer(content, _STL_TRIANGLE, offset=_STL_HEADER)
        vertices = body["corners"].reshape(-1, 3).astype(np.float64)
    whole = len(vertices) - len(vertices) % 3
    return vertices, np.arange(whole).reshape(-1, 3)


def _obj(content: bytes, limits: ReadLimits) -> _Triangles:
    vertices = _after_word(content, b"v", limits)
    faces = array("q")
    for line in _lines(content):
        word, *corners = line.split() or [b""]
        if word == b"f":
            limits.numbers(3 * len(corners), "the faces")
            # Vertex, texture and normal by slashes; negative numbers count from the end.
            numbers = [int(corner.split(b"/")[0]) for corner in corners]
            polygon = [n - 1 if n > 0 else n + len(vertices) for n in numbers]
            for b, c in pairwise(polygon[1:]):
                faces.extend((polygon[0], b, c))
    return vertices, np.array(faces, dtype=np.int64).reshape(-1, 3)


def _after_word(content: bytes, word: bytes, limits: ReadLimits) -> Float64Array:
    numbers = array("d")
    for line in _lines(content):
        limits.items(1, "the lines")
        own, *cells = line.split(None, 4) or [b""]
        if own == word:
            limits.numbers(3, "the vertices")
            x, y, z = map(float, cells[:3])
            numbers.extend((x, y, z))
    return np.array(numbers, dtype=np.float64).reshape(-1, 3)


def _lines(content: bytes) -> Iterator[bytes]:
    return iter(BytesIO(content.replace(b"\r", b"\n")))


def through_coal(path: Path) -> _Triangles:
    """Vertices (n, 3) and triangles (m, 3) of a mesh that coal reads."""
    coal = check.package("coal", extra="mesh")
    limits = ReadLimits()
    limits.bytes(path.stat().st_size, "the file")
    with refusing_damage("mesh"):
        mesh = coal.MeshLoader().load(str(path), np.ones(3))
        limits.numbers(3 * (mesh.num_vertices + mesh.num_tris), "the mesh")
        faces = [[mesh.tri_indices(i)[k] for k in range(3)] for i in range(mesh.num_tris)]
        return np.array(mesh.vertices()), np.array(faces, dtype=np.int64).reshape(-1, 3)
