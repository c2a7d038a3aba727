"""Vertices of a mesh file: STL and OBJ by themselves, other formats through the extra `mesh`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, MissingDependency

_STL_HEADER = 84  # bytes, the last four the number of triangles
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_vertices(path: Path) -> Float64Array:
    """All vertices (n, 3) of a mesh, repeated ones as well, in the file's unit.

    Raises InvalidInput, MissingDependency.
    """
    try:
        match path.suffix.lower():
            case ".stl":
                vertices = _stl(path.read_bytes())
            case ".obj":
                vertices = _after_word(path.read_bytes(), b"v")
            case _:
                vertices = _through_coal(path)
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{path}: not a mesh that can be read: {error}") from None
    if len(vertices) == 0 or not np.isfinite(vertices).all():
        raise InvalidInput(f"{path}: expected a mesh of finite vertices")
    return vertices


def _stl(content: bytes) -> Float64Array:
    # A binary file may begin with "solid" like a text: its length tells.
    triangles = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if len(content) != _STL_HEADER + triangles * _STL_TRIANGLE.itemsize:
        return _after_word(content, b"vertex")
    body = np.frombuffer(content, _STL_TRIANGLE, offset=_STL_HEADER)
    return body["corners"].reshape(-1, 3).astype(np.float64)


def _after_word(content: bytes, word: bytes) -> Float64Array:
    lines = (line.split() for line in content.splitlines())
    rows = [line[1:4] for line in lines if line and line[0] == word]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _through_coal(path: Path) -> Float64Array:
    try:
        import coal  # noqa: PLC0415
    except ImportError:
        raise MissingDependency("coal", extra="mesh") from None
    try:
        mesh = coal.MeshLoader().load(str(path), np.ones(3))
    except (RuntimeError, ValueError) as error:
        raise ValueError(error) from None
    return np.array(mesh.vertices())
