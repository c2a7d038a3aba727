"""The surfaces of a robot's links: triangles of their visual or collision geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from leadthrough import rotations
from leadthrough.arm.robot_files import find_mesh
from leadthrough.check import Float64Array
from leadthrough.drawing.palette import Colour
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.io.mesh import read_triangles
from leadthrough.shapes import surface
from leadthrough.shapes.surface import Surface


@dataclass(frozen=True, eq=False)
class Part:
    """A surface of a link, in the link's frame; without a colour if the URDF gives it none."""

    mesh: Surface
    colour: Colour | None = None


def parts_by_link(
    document: str, mesh_folders: Sequence[str]
) -> tuple[dict[str, list[Part]], tuple[str, ...]]:
    """The surfaces of each link of a URDF, and what cannot be shown."""
    robot = ElementTree.fromstring(document)
    colours = {name: colour for name, colour in map(_material, robot.findall("material")) if colour}
    found, remarks = {}, []
    for link in robot.findall("link"):
        name = link.get("name", "")
        parts, trouble = _of_link(link, mesh_folders, colours)
        if parts:
            found[name] = parts
        if trouble:
            instead = "its collision shape is shown" if parts else "it is left out"
            remarks.append(f"link {name}: {trouble}; {instead}")
    return found, tuple(remarks)


def _of_link(
    link: ElementTree.Element, mesh_folders: Sequence[str], colours: Mapping[str, Colour]
) -> tuple[list[Part], str]:
    """The link's surfaces, and why those that it should be shown by cannot be read."""
    trouble = ""
    for kind in sorted(("visual", "collision"), key=lambda kind: _needs_library(link, kind)):
        try:
            parts = list(_read(link.findall(kind), mesh_folders, colours))
        except (InvalidInput, MissingDependency) as error:
            trouble = trouble or str(error)
            continue
        if parts:
            return parts, trouble
    return [], trouble


def _needs_library(link: ElementTree.Element, kind: str) -> bool:
    files = [mesh.get("filename", "").lower() for mesh in link.findall(f"{kind}/geometry/mesh")]
    return not all(file.endswith((".stl", ".obj")) for file in files)


def _read(
    elements: Sequence[ElementTree.Element],
    mesh_folders: Sequence[str],
    colours: Mapping[str, Colour],
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


def _surface(geometry: ElementTree.Element | None, mesh_folders: Sequence[str]) -> Surface:
    for shape in geometry if geometry is not None else ():
        radius, length = (float(shape.get(name, "0")) for name in ("radius", "length"))
        match shape.tag:
            case "box":
                return surface.box(_numbers(shape, "size", (0.0, 0.0, 0.0)))
            case "cylinder":
                return surface.cylinder(radius, length)
            case "capsule":
                return surface.capsule(radius, length)
            case "sphere":
                return surface.sphere(radius)
            case "mesh":
                return _mesh(shape, mesh_folders)
    raise InvalidInput("geometry: expected a box, cylinder, capsule, sphere or mesh")


def _mesh(element: ElementTree.Element, mesh_folders: Sequence[str]) -> Surface:
    path = find_mesh(element.get("filename", ""), mesh_folders)
    if path is None:
        raise InvalidInput(f"mesh: {element.get('filename')} is not found")
    vertices, faces = read_triangles(path)
    return Surface(vertices * _numbers(element, "scale", (1.0, 1.0, 1.0)), faces)


def _material(element: ElementTree.Element) -> tuple[str, Colour | None]:
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
