"""The links of a robot: convex parts and surfaces as its URDF states them, and their poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

import leadthrough._core as core
from leadthrough import rotations
from leadthrough.arm.model import ArmModel, Body
from leadthrough.arm.robot_files import find_mesh, mesh_parts
from leadthrough.check import Float64Array, InvalidInput, MissingDependency
from leadthrough.shapes.mesh import hull
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.shapes.shape import ConvexPart, Primitive
from leadthrough.shapes.surface import Surface, merged


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
    read: dict[tuple[str | float, ...], Surface] = {}  # both arms of a robot share their files
    for link in robot.links:
        parts, trouble = _of_link(robot, link, mesh_folders, read)
        if parts:
            found[link] = parts
        if trouble:
            instead = "its collision shape is shown" if parts else "it is left out"
            remarks.append(f"link {link}: {trouble}; {instead}")
    return found, tuple(remarks)


def filled(robot: core.Robot, mesh_folders: Sequence[str], density: float) -> dict[str, Body]:
    """The links without a stated mass as if their shapes, or what is drawn of them, were solid."""
    stated, found = robot.inertias, {}
    for link in robot.links:
        pieces = robot.geometry(link, "collision") or robot.geometry(link, "visual")
        if pieces and stated[link][0] == 0.0:
            solid = merged([each for piece in pieces for each in _solid(piece, link, mesh_folders)])
            volume, centre, spread = solid.moments()
            moments = density * volume * (np.trace(spread) * np.eye(3) - spread)
            found[link] = density * volume, centre, moments
    return found


def _solid(geometry: core.Geometry, link: str, mesh_folders: Sequence[str]) -> list[Surface]:
    if geometry.kind != "mesh":
        return [_primitive(geometry).placed_surface()]
    turn = rotations.to_matrix(_orientation(geometry)[None])[0]
    parts = mesh_parts(link, geometry.file, geometry.sizes, mesh_folders)
    return [hull(each).moved(geometry.position, turn) for each in parts]


def _of_link(
    robot: core.Robot,
    link: str,
    mesh_folders: Sequence[str],
    read: dict[tuple[str | float, ...], Surface],
) -> tuple[list[LinkSurface], str]:
    """The link's surfaces, and the reason if the preferred ones cannot be read."""
    trouble = ""
    for pieces in (robot.geometry(link, role) for role in ("visual", "collision")):
        try:
            parts = [
                LinkSurface(_surface(each, mesh_folders, read), each.colour) for each in pieces
            ]
        except (InvalidInput, MissingDependency) as error:
            trouble = trouble or str(error)
            continue
        if parts:
            return parts, trouble
    return [], trouble


def _convex_parts(
    geometry: core.Geometry, link: str, mesh_folders: Sequence[str]
) -> list[ConvexPart]:
    if geometry.kind != "mesh":
        return list(_primitive(geometry).convex_parts())
    return [
        ConvexPart("mesh", (), geometry.position, _orientation(geometry), vertices)
        for vertices in mesh_parts(link, geometry.file, geometry.sizes, mesh_folders)
    ]


def _surface(
    geometry: core.Geometry,
    mesh_folders: Sequence[str],
    read: dict[tuple[str | float, ...], Surface],
) -> Surface:
    if geometry.kind != "mesh":
        return _primitive(geometry).placed_surface()
    key = (geometry.file, *geometry.sizes, *geometry.position, *geometry.angles)
    if key not in read:
        read[key] = _read_mesh(geometry, mesh_folders)
    return read[key]


def _read_mesh(geometry: core.Geometry, mesh_folders: Sequence[str]) -> Surface:
    """The surface of a mesh file, in the frame of its link."""
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


def link_poses(arm: ArmModel, q: Float64Array) -> dict[str, tuple[Float64Array, Float64Array]]:
    """Rotations (n, 3, 3) and positions (n, 3), m, of each link in the frame of the arm's base."""
    values = _values(arm, q)
    links = arm.robot.links
    orientations = {0: np.tile(np.eye(3), (len(q), 1, 1))}
    positions = {0: np.zeros((len(q), 3))}
    for joint in arm.robot.tree:
        rotation, shift = _motion(joint, values)
        here = orientations[joint.parent]
        offset = joint.position + shift @ joint.rotation.T
        positions[joint.child] = positions[joint.parent] + np.einsum("nij,nj->ni", here, offset)
        orientations[joint.child] = here @ (joint.rotation @ rotation)
    base = links.index(arm.base)
    back = orientations[base].transpose(0, 2, 1)
    away = {i: positions[i] - positions[base] for i in positions}
    return {
        links[i]: (back @ orientations[i], np.einsum("nij,nj->ni", back, away[i]))
        for i in orientations
    }


def _values(arm: ArmModel, q: Float64Array) -> dict[str, Float64Array]:
    """Positions (n,) of each joint, by its name; meaningless for joints that mimic another."""
    moved = dict(zip(arm.joint_names, q.T, strict=True))
    values = {}
    for joint in arm.robot.tree:
        still = arm.locked_joints.get(joint.name, min(max(0.0, joint.lower), joint.upper))
        values[joint.name] = moved.get(joint.name, np.full(len(q), still))
    return values


def _motion(
    joint: core.Joint, values: Mapping[str, Float64Array]
) -> tuple[Float64Array, Float64Array]:
    """Rotations (n, 3, 3) and shifts (n, 3), m, of a joint's child from its pose at zero."""
    value = values[joint.name]
    if joint.mimic is not None:
        value = joint.mimic.multiplier * values[joint.mimic.joint] + joint.mimic.offset
    along = np.outer(value, joint.axis)
    still = np.zeros_like(along)
    if joint.kind == "prismatic":
        return np.tile(np.eye(3), (len(value), 1, 1)), along
    turn = along if joint.kind in ("revolute", "continuous") else still
    return rotations.to_matrix(rotations.exp(turn)), still
