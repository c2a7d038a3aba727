"""Mesh collision geometry of a URDF: each mesh counts as its convex hull.

The hull contains the mesh, so no collision is missed, but the free space inside a hollow mesh
counts as occupied.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path
from urllib.parse import unquote, urlparse

import numpy as np

from leadthrough.arm.loading import is_document
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, InvalidRobot

_BESIDE_MESHES = ("urdf", "robots", "xacro")  # a package's folders for descriptions


def folders(
    path_or_xml: str | PathLike[str], mesh_folders: Sequence[str | PathLike[str]]
) -> tuple[str, ...]:
    """The folders in which an arm's meshes are looked for: those given, then the URDF's own."""
    if isinstance(mesh_folders, str | Path) or not isinstance(mesh_folders, Sequence):
        raise InvalidInput(f"mesh_folders: expected a sequence of folders, got {mesh_folders!r}")
    try:
        given = [Path(folder).resolve() for folder in mesh_folders]
    except (TypeError, ValueError, OSError) as error:
        raise InvalidInput(f"mesh_folders: expected paths of folders: {error}") from None
    if not is_document(path_or_xml):
        given.append(Path(path_or_xml).resolve().parent)
    return tuple(str(folder) for folder in given)


def hull_vertices(
    link: str, file: str, scale: Float64Array, folders: Sequence[str]
) -> Float64Array:
    """Vertices (n, 3) of the convex hull of a link's mesh in m, in the mesh's frame."""
    # Only robots with meshes need these, and they take long to load.
    from scipy.spatial import ConvexHull, QhullError

    from leadthrough.io.mesh import read_vertices

    where = f"link {link!r}"
    path = find_mesh(file, folders)
    if path is None:
        places = ", ".join(folders) or "none"
        raise InvalidRobot(
            where,
            f"mesh {file!r} was not found in the robot's folders ({places}); if it lies elsewhere, "
            "name its folder in mesh_folders",
        )
    try:
        vertices = read_vertices(path) * scale
        return np.asarray(vertices[ConvexHull(vertices).vertices])
    except InvalidInput as error:
        raise InvalidRobot(where, str(error)) from None
    except QhullError:
        raise InvalidRobot(where, f"mesh {file!r} is flat or has too few vertices") from None


def find_mesh(file: str, folders: Sequence[str]) -> Path | None:
    """The file that a URDF's mesh names, or None if it is not found or lies outside the robot."""
    try:
        for candidate, root in _candidates(file, folders):
            plain = Path(os.path.normpath(candidate))  # without the links' targets
            if plain.is_relative_to(root) and candidate.is_file():
                return candidate
    except ValueError:  # no address, or no path
        return None
    return None


def _candidates(file: str, folders: Sequence[str]) -> Iterator[tuple[Path, Path]]:
    """Where a mesh may be, and the folder that it must not leave there."""
    address = urlparse(file)
    if address.scheme == "package":
        name, rest = address.netloc, unquote(address.path).lstrip("/")
        starts = [Path(folder).resolve() for folder in folders if name.strip(".")]
        for start in starts:
            for place in (start, *start.parents):
                yield place / name / rest, place / name
        for start in starts:
            root = _root(start)
            for place in (start, *start.parents):
                if place.is_relative_to(root):
                    yield place / rest, root
        parts = Path(rest).parts
        if ".." not in parts:
            for start in starts:
                yield from ((start / Path(*parts[i:]), start) for i in range(1, len(parts)))
        return
    path = Path(unquote(address.path) if address.scheme == "file" else file)
    for folder in folders:
        yield Path(folder) / path, _root(Path(folder))  # of an absolute path it is the path itself


def _root(folder: Path) -> Path:
    """The folder of the robot that has this one."""
    for place in (folder, *folder.parents):
        if (place / "package.xml").is_file():
            return place
    return folder.parent if folder.name in _BESIDE_MESHES else folder
