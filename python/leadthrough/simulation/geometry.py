"""Collision shapes for MuJoCo: of a URDF's links, of attached objects and of obstacles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from leadthrough import optional, rotations
from leadthrough.arm import Arm
from leadthrough.arm.meshes import hull_vertices
from leadthrough.check import Float64Array
from leadthrough.shapes import Box, Capsule, Cylinder, Mesh, PointCloud, Shape, Sphere

_UNTURNED = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex solid in the frame of its body."""

    kind: str  # "box", "sphere", "capsule", "cylinder" or "mesh"
    size: tuple[float, ...]  # as MuJoCo takes it, half lengths; of a mesh ()
    position: Float64Array  # (3,), m
    orientation: Float64Array  # (4,), w, x, y, z
    vertices: Float64Array | None = None  # (n, 3), m, of a mesh in its own frame

    def add_to(self, spec: Any, body: Any) -> None:
        """Adds the solid to a body of a MuJoCo model that is being specified."""
        mujoco = optional.load("mujoco", extra="simulation")
        geom = body.add_geom(
            type=getattr(mujoco.mjtGeom, f"mjGEOM_{self.kind.upper()}"),
            pos=self.position,
            quat=self.orientation,
        )
        geom.size[: len(self.size)] = self.size
        if self.vertices is not None:
            mesh = spec.add_mesh(name=f"mesh {len(spec.meshes)}")
            mesh.uservert = self.vertices.ravel()
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
            geom.meshname = mesh.name


def solids_of(shape: Shape) -> Iterator[Solid]:
    """A shape as convex solids; a cloud as a ball for each of its points."""
    turned = np.array(_UNTURNED) if isinstance(shape, Sphere) else shape.orientation
    at = shape.position
    if isinstance(shape, Box):
        yield Solid("box", tuple(0.5 * shape.size), at, turned)
    elif isinstance(shape, Sphere):
        yield Solid("sphere", (shape.radius,), at, turned)
    elif isinstance(shape, Capsule | Cylinder):
        # A capsule without length is a ball, which MuJoCo wants called one.
        kind = type(shape).__name__.lower() if shape.length > 0.0 else "sphere"
        yield Solid(kind, (shape.radius, 0.5 * shape.length), at, turned)
    elif isinstance(shape, Mesh):
        for part in shape.parts:
            yield Solid("mesh", (), at, turned, part.vertices)
    elif isinstance(shape, PointCloud):
        for point in shape._outline():
            yield Solid("sphere", (shape.radius,), point, np.array(_UNTURNED))


def link_solids(arm: Arm) -> dict[str, list[Solid]]:
    """The collision shapes of each link of the arm's robot, in the links' frames."""
    links = ElementTree.fromstring(arm.document).findall("link")
    return {
        link.get("name", ""): [
            _solid(element, link.get("name", ""), arm.mesh_folders)
            for element in link.findall("collision")
        ]
        for link in links
    }


def _solid(element: ElementTree.Element, link: str, folders: Sequence[str]) -> Solid:
    origin = element.find("origin")
    at = _numbers(origin, "xyz", "0 0 0")
    angles = _numbers(origin, "rpy", "0 0 0")
    turned = rotations.from_euler(angles[None], convention="xyz")[0]
    shape = next(iter(element.find("geometry") or ()))
    radius, length = (float(shape.get(name, "0")) for name in ("radius", "length"))
    if shape.tag == "box":
        return Solid("box", tuple(0.5 * _numbers(shape, "size", "0 0 0")), at, turned)
    if shape.tag == "mesh":
        scale = _numbers(shape, "scale", "1 1 1")
        vertices = hull_vertices(link, shape.get("filename", ""), scale, folders)
        return Solid("mesh", (), at, turned, vertices)
    size = (radius,) if shape.tag == "sphere" else (radius, 0.5 * length)
    return Solid(shape.tag, size, at, turned)


def _numbers(element: ElementTree.Element | None, name: str, usual: str) -> Float64Array:
    text = usual if element is None else element.get(name, usual)
    return np.array([float(word) for word in text.split()])
