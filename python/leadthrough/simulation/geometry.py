"""Collision shapes for MuJoCo: of a URDF's links, of attached objects and of obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np

from leadthrough import optional, rotations
from leadthrough.arm import Arm
from leadthrough.arm.robot_files import hull_vertices
from leadthrough.check import Float64Array
from leadthrough.shapes.shape import ConvexPart


def add_part(part: ConvexPart, spec: Any, body: Any) -> None:
    """Adds a convex part to a body of a MuJoCo model that is being specified."""
    mujoco = optional.load("mujoco", extra="simulation")
    geom = body.add_geom(
        type=getattr(mujoco.mjtGeom, f"mjGEOM_{part.kind.upper()}"),
        pos=part.position,
        quat=part.orientation,
    )
    geom.size[: len(part.half_sizes)] = part.half_sizes
    if part.vertices is not None:
        mesh = spec.add_mesh(name=f"mesh {len(spec.meshes)}")
        mesh.uservert = part.vertices.ravel()
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        geom.meshname = mesh.name


def link_solids(arm: Arm) -> dict[str, list[ConvexPart]]:
    """The collision shapes of each link of the arm's robot, in the links' frames."""
    links = ElementTree.fromstring(arm.document).findall("link")
    return {
        link.get("name", ""): [
            _solid(element, link.get("name", ""), arm.mesh_folders)
            for element in link.findall("collision")
        ]
        for link in links
    }


def _solid(element: ElementTree.Element, link: str, folders: Sequence[str]) -> ConvexPart:
    origin = element.find("origin")
    at = _numbers(origin, "xyz", "0 0 0")
    angles = _numbers(origin, "rpy", "0 0 0")
    turned = rotations.from_euler(angles[None], convention="xyz")[0]
    shape = next(iter(element.find("geometry") or ()))
    radius, length = (float(shape.get(name, "0")) for name in ("radius", "length"))
    if shape.tag == "box":
        return ConvexPart("box", tuple(0.5 * _numbers(shape, "size", "0 0 0")), at, turned)
    if shape.tag == "mesh":
        scale = _numbers(shape, "scale", "1 1 1")
        vertices = hull_vertices(link, shape.get("filename", ""), scale, folders)
        return ConvexPart("mesh", (), at, turned, vertices)
    size = (radius,) if shape.tag == "sphere" else (radius, 0.5 * length)
    return ConvexPart(shape.tag, size, at, turned)


def _numbers(element: ElementTree.Element | None, name: str, usual: str) -> Float64Array:
    text = usual if element is None else element.get(name, usual)
    return np.array([float(word) for word in text.split()])
