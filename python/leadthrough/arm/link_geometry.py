"""The geometry of a robot's links, as its URDF states it: convex parts and surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import leadthrough._core as core
from leadthrough import rotations
from leadthrough.arm.robot_files import find_mesh, hull_vertices
from leadthrough.check import Float64Array, InvalidInput, MissingDependency
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.shapes.shape import ConvexPart, Primitive
from leadthrough.shapes.surface import Surface


@dataclass(frozen=True, eq=False)
class LinkSurface:
    """A surface of a link, in the link's frame; without a colour if the URDF gives it none."""

    surface: Surface
    colour: tuple[float, float, float] | None = None


def convex_parts(robot: core.Robot, mesh_folders: Sequence[str]) -> dict[str, list[ConvexPart]]:
    """The collision geometry of each link, in the link's frame."""
    return {
        link: [
            part
            for geometry in robot.geometry(link, "collision")
            for part in _convex_parts(geometry, link, mesh_folders)
        ]
        for link in robot.links
    }


def surfaces(
    robot: core.Robot, mesh_folders: Sequence[str]
) -> tuple[dict[str, list[LinkSurface]], tuple[str, ...]]:
    """The surfaces of each link, visual or collision geometry, and reasons for missing ones."""
    found, remarks = {}, []
    for link in robot.links:
        parts, trouble = _of_link(robot, link, mesh_folders)
        if parts:
            found[link] = parts
        if trouble:
            instead = "its collision shape is shown" if parts else "it is left out"
            remarks.append(f"link {link}: {trouble}; {instead}")
    return found, tuple(remarks)


def _of_link(
    robot: core.Robot, link: str, mesh_folders: Sequence[str]
) -> tuple[list[LinkSurface], str]:
    """The link's surfaces, and the reason if the preferred ones cannot be read."""
    trouble = ""
    choices = [robot.geometry(link, role) for role in ("visual", "collision")]
    for pieces in sorted(choices, key=_needs_library):
        try:
            parts = [LinkSurface(_surface(each, mesh_folders), each.colour) for each in pieces]
        except (InvalidInput, MissingDependency) as error:
            trouble = trouble or str(error)
            continue
        if parts:
            return parts, trouble
    return [], trouble


def _needs_library(pieces: Sequence[core.Geometry]) -> bool:
    files = [each.file.lower() for each in pieces if each.kind == "mesh"]
    return not all(file.endswith((".stl", ".obj")) for file in files)


def _convex_parts(
    geometry: core.Geometry, link: str, mesh_folders: Sequence[str]
) -> list[ConvexPart]:
    if geometry.kind != "mesh":
        return list(_primitive(geometry).convex_parts())
    vertices = hull_vertices(link, geometry.file, geometry.sizes, mesh_folders)
    return [ConvexPart("mesh", (), geometry.position, _orientation(geometry), vertices)]


def _surface(geometry: core.Geometry, mesh_folders: Sequence[str]) -> Surface:
    if geometry.kind != "mesh":
        return _primitive(geometry).placed_surface()
    from leadthrough.io.mesh import read_triangles  # only robots with meshes need it

    path = find_mesh(geometry.file, mesh_folders)
    if path is None:
        raise InvalidInput(f"mesh: {geometry.file} is not found")
    vertices, faces = read_triangles(path)
    rotation = rotations.to_matrix(_orientation(geometry)[None])[0]
    return Surface(vertices * geometry.sizes, faces).moved(geometry.position, rotation)


def _primitive(geometry: core.Geometry) -> Primitive:
    solid = PRIMITIVES[geometry.kind].from_sizes(geometry.sizes, geometry.position)
    return solid.at(geometry.position, _orientation(geometry))


def _orientation(geometry: core.Geometry) -> Float64Array:
    return np.asarray(rotations.from_euler(geometry.angles[None], convention="xyz")[0])
