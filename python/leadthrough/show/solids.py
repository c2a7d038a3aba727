"""Triangle meshes of solids: bodies of revolution, boxes and tubes around paths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length
from leadthrough.repr import ShortRepr
from leadthrough.shapes import Box, Capsule, Cylinder, PointCloud, Shape, Sphere
from leadthrough.shapes import Mesh as HullMesh

_AROUND = 40
_TUBE_SIDES = 12
_ARC_STEPS = 12
_MOST_DOTS = 4000  # of a cloud; more would make pages slow to load and turn
_UNTURNED = np.eye(3)


@dataclass(frozen=True, eq=False)
class Mesh(ShortRepr):
    """A surface of triangles.

    Attributes:
        vertices: (n, 3), m.
        faces: indices of vertices (m, 3), anticlockwise as seen from outside.
    """

    vertices: Float64Array
    faces: NDArray[np.int64]

    def moved(self, position: Float64Array, rotation: Float64Array = _UNTURNED) -> Mesh:
        """The mesh with each point p moved to rotation p + position, (3, 3) and (3,), m."""
        return Mesh(self.vertices @ rotation.T + position, self.faces)


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh of all, of which there is at least one."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def of_shape(shape: Shape) -> Mesh:
    """The surface of a shape at its own pose."""
    if isinstance(shape, Sphere):
        return sphere(shape.radius).moved(shape.position)
    turned = rotations.to_matrix(shape.orientation[None])[0]
    return unplaced(shape).moved(shape.position, turned)


def unplaced(shape: Shape) -> Mesh:
    """The surface of a shape about the origin of its own frame."""
    if isinstance(shape, Box):
        return box(shape.size)
    if isinstance(shape, Cylinder):
        return cylinder(shape.radius, shape.length)
    if isinstance(shape, HullMesh):
        return merged([Mesh(part.vertices, part.faces) for part in shape.parts])
    if isinstance(shape, PointCloud):
        return dots(shape.points, shape.radius)
    return (
        capsule(shape.radius, shape.length) if isinstance(shape, Capsule) else sphere(shape.radius)
    )


def box(size: Float64Array) -> Mesh:
    """A box about the origin, with full edge lengths (3,), m."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    return Mesh(0.5 * signs * np.asarray(size), np.array(faces))


def cylinder(radius: float, length: float) -> Mesh:
    """A cylinder along z, centred at the origin; lengths in m."""
    half = 0.5 * length
    return _turned([(0.0, -half), (radius, -half), (radius, half), (0.0, half)])


def sphere(radius: float) -> Mesh:
    """A ball centred at the origin; radius in m."""
    return capsule(radius, 0.0)


def capsule(radius: float, length: float) -> Mesh:
    """A capsule along z, centred at the origin, with the length between its ends' centres, m."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * _ARC_STEPS + 1)
    shift = np.where(angles > 0.0, 0.5 * length, -0.5 * length)
    profile = np.column_stack([radius * np.cos(angles), radius * np.sin(angles) + shift])
    profile[[0, -1], 0] = 0.0
    return _turned(profile)


def dots(points: Float64Array, radius: float) -> Mesh:
    """Octahedra around points (n, 3), of many only some of them, m."""
    count = min(len(points), _MOST_DOTS)
    shown = points[np.linspace(0, len(points) - 1, count).round().astype(np.int64)]
    corners = radius * np.concatenate([np.eye(3), -np.eye(3)])
    sides = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    faces = 6 * np.arange(count)[:, None, None] + np.array(sides)
    return Mesh((shown[:, None] + corners).reshape(-1, 3), faces.reshape(-1, 3))


def tube(path: Float64Array, radius: float, *, sides: int = _TUBE_SIDES) -> Mesh:
    """A round tube around a path (n, 3), closed at both ends; lengths in m."""
    points = without_repeats(path)
    if len(points) < 2:
        return sphere(radius).moved(points[0])
    across = radius * _circle(sides)
    return _swept(points, np.einsum("ki,nij->nkj", across, cross_sections(points)))


def uncertainty_tube(
    means: Float64Array, covariances: Float64Array, *, deviations: float = 2.0
) -> Mesh:
    """The tube whose cross-sections are the ellipses of a distribution about its mean path."""
    frames = cross_sections(means)
    across = np.einsum("nik,nkl,njl->nij", frames, covariances, frames)
    values, axes = np.linalg.eigh(across)
    spread = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :] @ axes.transpose(0, 2, 1)
    rings = np.einsum("kj,nij->nki", deviations * _circle(2 * _TUBE_SIDES), spread)
    return _swept(means, np.einsum("nki,nij->nkj", rings, frames))


def without_repeats(path: Float64Array) -> Float64Array:
    """The path (n, 3) without points equal to the one before."""
    moves = np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-9
    return np.asarray(path[np.concatenate([[True], moves])])


def thinned(path: Float64Array, count: int) -> Float64Array:
    """At most `count` points of a path (n, d), evenly spaced along it, with both ends."""
    if len(path) <= count:
        return path
    along = arc_length(path)
    wanted = np.linspace(0.0, along[-1], count)
    return np.column_stack([np.interp(wanted, along, column) for column in path.T])


def cross_sections(path: Float64Array) -> Float64Array:
    """Two unit vectors (n, 2, 3) across the path (n, 3) at each point, with the least twist.

    Source: Wang et al. 2008, "Computation of rotation minimizing frames", table I.
    """
    tangents = np.gradient(path, axis=0)
    lengths = np.linalg.norm(tangents, axis=1, keepdims=True)
    tangents = np.divide(tangents, lengths, out=np.tile([0.0, 0.0, 1.0], (len(path), 1)),
                         where=lengths > 0.0)  # fmt: skip
    least = np.eye(3)[int(np.argmin(np.abs(tangents[0])))]
    across, pairs = np.cross(tangents[0], least), []
    for tangent, turn in zip(tangents, _least_turns(path, tangents), strict=True):
        across = turn @ across
        across = across - (across @ tangent) * tangent
        across = across / math.sqrt(across @ across)
        pairs.append(across)
    first = np.array(pairs)
    return np.stack([first, np.cross(tangents, first)], axis=1)


def _least_turns(path: Float64Array, tangents: Float64Array) -> Float64Array:
    """Matrices (n, 3, 3), each of which reflects twice: from the point before to this one."""
    turns = np.tile(np.eye(3), (len(path), 1, 1))
    steps = np.diff(path, axis=0)
    back = _reflections(steps)
    left = tangents[1:] - np.einsum("nij,nj->ni", back, tangents[:-1])
    moved = steps.any(axis=1)
    turns[1:][moved] = (_reflections(left) @ back)[moved]
    return turns


def _reflections(normals: Float64Array) -> Float64Array:
    """Reflections (n, 3, 3) in the planes across vectors (n, 3); of 0, nothing moves."""
    squared = np.einsum("ni,ni->n", normals, normals)[:, None, None]
    factors = np.divide(2.0, squared, out=np.zeros_like(squared), where=squared > 0.0)
    return np.asarray(np.eye(3) - factors * normals[:, :, None] * normals[:, None])


def _circle(count: int) -> Float64Array:
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _turned(profile: Sequence[tuple[float, float]] | Float64Array) -> Mesh:
    """The surface of revolution about z of a profile of radii and heights (n, 2), upwards."""
    radii, heights = np.asarray(profile, dtype=np.float64).T
    circle = _circle(_AROUND)
    rings = np.zeros((len(radii), _AROUND, 3))
    rings[:, :, :2] = radii[:, None, None] * circle
    rings[:, :, 2] = heights[:, None]
    mesh = Mesh(rings.reshape(-1, 3), _rings_joined(len(radii), _AROUND))
    return _without_slivers(mesh)


def _swept(path: Float64Array, rings: Float64Array) -> Mesh:
    """The closed surface through rings (n, k, 3), given relative to the points of a path (n, 3)."""
    count, sides = rings.shape[:2]
    vertices = (path[:, None] + rings).reshape(-1, 3)
    ends = np.arange(sides)
    after = np.roll(ends, -1)
    first, last = len(vertices), len(vertices) + 1
    caps = [
        np.column_stack([after, ends, np.full(sides, first)]),
        np.column_stack([ends, after, np.full(sides, 0)]) + (count - 1) * sides,
    ]
    caps[1][:, 2] = last
    faces = np.concatenate([_rings_joined(count, sides), *caps])
    return Mesh(np.concatenate([vertices, path[[0, -1]]]), faces)


def _rings_joined(count: int, sides: int) -> NDArray[np.int64]:
    """Two triangles for each side between one ring and the next."""
    here = np.arange(sides)
    after = np.roll(here, -1)
    one = np.concatenate(
        [
            np.column_stack([here, after, after + sides]),
            np.column_stack([here, after + sides, here + sides]),
        ]
    )
    return np.concatenate([one + sides * i for i in range(count - 1)])


def _without_slivers(mesh: Mesh) -> Mesh:
    """The mesh without triangles of no area, as at poles."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Mesh(mesh.vertices, mesh.faces[areas > 1e-12 * areas.max()])
