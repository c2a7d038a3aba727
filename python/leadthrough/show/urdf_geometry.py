"""What a robot's links look like: the triangles of their visual or collision geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from leadthrough import rotations
from leadthrough.arm.meshes import find_mesh
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.io.mesh import read_triangles
from leadthrough.show import solids
from leadthrough.show.solids import Mesh

_Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Part:
    """A surface of a link, in the link's frame. colour: sRGB in [0, 1], or None."""

    mesh: Mesh
    colour: _Colour | None = None


def parts_by_link(document: str, mesh_folders: Sequence[str]) -> dict[str, list[Part]]:
    """What can be drawn of each link of a URDF, links that look like nothing left out.

    A link's visual geometry, or its collision geometry where there is none or a mesh of it cannot
    be read: a view should open all the same. Shapes and meshes that are read without another
    library come first, since they are small and clean. The document is one that the arm accepted.
    """
    robot = ElementTree.fromstring(document)
    colours = {name: colour for name, colour in map(_material, robot.findall("material")) if colour}
    found = {}
    for link in robot.findall("link"):
        kinds = sorted(("visual", "collision"), key=lambda kind: _needs_library(link, kind))
        for kind in kinds:
            parts = _parts(link.findall(kind), mesh_folders, colours)
            if parts:
                found[link.get("name", "")] = parts
                break
    return found


def _needs_library(link: ElementTree.Element, kind: str) -> bool:
    files = [mesh.get("filename", "").lower() for mesh in link.findall(f"{kind}/geometry/mesh")]
    return not all(file.endswith((".stl", ".obj")) for file in files)


def _parts(
    elements: Sequence[ElementTree.Element],
    mesh_folders: Sequence[str],
    colours: Mapping[str, _Colour],
) -> list[Part]:
    try:
        return list(_read(elements, mesh_folders, colours))
    except (InvalidInput, MissingDependency):
        return []


def _read(
    elements: Sequence[ElementTree.Element],
    mesh_folders: Sequence[str],
    colours: Mapping[str, _Colour],
) -> Iterator[Part]:
    for element in elements:
        origin = element.find("origin")
        position, angles = (_numbers(origin, name, (0.0, 0.0, 0.0)) for name in ("xyz", "rpy"))
        turned = rotations.to_matrix(rotations.from_euler(angles[None], convention="xyz"))[0]
        colour = None
        material = element.find("material")
        if material is not None:
            name, colour = _material(material)
            colour = colour or colours.get(name)
        yield Part(_surface(element.find("geometry"), mesh_folders).moved(position, turned), colour)


def _surface(geometry: ElementTree.Element | None, mesh_folders: Sequence[str]) -> Mesh:
    for shape in geometry if geometry is not None else ():
        radius, length = (float(shape.get(name, "0")) for name in ("radius", "length"))
        match shape.tag:
            case "box":
                return solids.box(_numbers(shape, "size", (0.0, 0.0, 0.0)))
            case "cylinder":
                return solids.cylinder(radius, length)
            case "capsule":
                return solids.capsule(radius, length)
            case "sphere":
                return solids.sphere(radius)
            case "mesh":
                return _mesh(shape, mesh_folders)
    raise InvalidInput("geometry: of no kind that can be drawn")


def _mesh(element: ElementTree.Element, mesh_folders: Sequence[str]) -> Mesh:
    path = find_mesh(element.get("filename", ""), mesh_folders)
    if path is None:
        raise InvalidInput(f"mesh: {element.get('filename')} is not found")
    vertices, faces = read_triangles(path)
    return Mesh(vertices * _numbers(element, "scale", (1.0, 1.0, 1.0)), faces)


def _material(element: ElementTree.Element) -> tuple[str, _Colour | None]:
    colour = element.find("color")
    if colour is None:
        return element.get("name", ""), None
    red, green, blue = _numbers(colour, "rgba", (0.5, 0.5, 0.5, 1.0))[:3].tolist()
    return element.get("name", ""), (red, green, blue)


def _numbers(
    element: ElementTree.Element | None, name: str, usual: Sequence[float]
) -> Float64Array:
    text = None if element is None else element.get(name)
    return np.array(usual if text is None else [float(word) for word in text.split()])
