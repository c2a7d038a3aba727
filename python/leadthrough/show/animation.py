"""Surfaces in layers, such as tubes around paths, and the poses of the links that carry them.

It knows no renderer: the HTML page, the notebook and the live view draw the same animation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.arm.link_geometry import link_poses
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.drawing.palette import Colour
from leadthrough.motion import JointTrajectory, in_order, lerp
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes.surface import Surface, circle, joined_rings, sphere

_SIDES = 12
# Faces that meet at a smaller angle belong to one curved surface.
_CREASE = np.radians(35.0)
# Corners of different triangles nearer than this fraction of the mesh's extent are one point.
_WELD = 1e-6


def tube(path: Float64Array, radius: float, *, sides: int = _SIDES) -> Surface:
    """A round tube around a path (n, 3), closed at both ends; lengths in m."""
    apart = np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-9
    points = path[np.concatenate([[True], apart])]
    if len(points) < 2:
        return sphere(radius).moved(points[0])
    across = radius * circle(sides)
    return _swept(points, np.einsum("ki,nij->nkj", across, cross_sections(points)))


def uncertainty_tube(
    means: Float64Array, covariances: Float64Array, *, deviations: float = 2.0
) -> Surface:
    """The tube whose cross-sections are the ellipses of a distribution about its mean path."""
    frames = cross_sections(means)
    across = np.einsum("nik,nkl,njl->nij", frames, covariances, frames)
    values, axes = np.linalg.eigh(across)
    spread = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :] @ axes.transpose(0, 2, 1)
    rings = np.einsum("kj,nij->nki", deviations * circle(2 * _SIDES), spread)
    return _swept(means, np.einsum("nki,nij->nkj", rings, frames))


def thinned(path: Float64Array, count: int) -> Float64Array:
    """At most `count` points of a path (n, d), evenly spaced along it, with both ends."""
    if len(path) <= count:
        return path
    along = arc_length(path)
    wanted = np.linspace(0.0, along[-1], count)
    return lerp(wanted, along, path)


def cross_sections(path: Float64Array) -> Float64Array:
    """Two unit vectors (n, 2, 3) across the path (n, 3) at each point, with the least twist."""
    # Wang et al. 2008, "Computation of rotation minimizing frames", table I.
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


def creased(mesh: Surface) -> tuple[Surface, Float64Array]:
    """The mesh with separate vertices on both sides of creases, and unit normals (n, 3)."""
    corners = mesh.vertices[mesh.faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    flat = np.divide(areas, lengths, out=np.zeros_like(areas), where=lengths > 0.0)
    points = _welded(mesh)[mesh.faces].ravel()
    face_of = np.repeat(np.arange(len(mesh.faces)), 3)
    normals = _around(points, flat[face_of], areas[face_of])
    keys = np.column_stack([points, np.round(normals * 1e3).astype(np.int64)])
    _, first, faces = np.unique(_numbered(keys), return_index=True, return_inverse=True)
    vertices = mesh.vertices[mesh.faces.ravel()[first]]
    return Surface(vertices, faces.reshape(-1, 3)), normals[first]


def smooth(mesh: Surface) -> tuple[Surface, Float64Array]:
    """The mesh and unit normals (n, 3) of its vertices, without creases."""
    corners = mesh.vertices[mesh.faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return mesh, _unit_sums(mesh.faces.ravel(), np.repeat(areas, 3, axis=0), len(mesh.vertices))


def _unit_sums(points: NDArray[np.int64], vectors: Float64Array, count: int) -> Float64Array:
    """Sums of the vectors (k, 3) that belong to each point, of unit length."""
    columns = [np.bincount(points, weights=column, minlength=count) for column in vectors.T]
    sums = np.column_stack(columns)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    upwards = np.tile([0.0, 0.0, 1.0], (count, 1))
    return np.asarray(np.divide(sums, lengths, out=upwards, where=lengths > 0.0))


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


def _swept(path: Float64Array, rings: Float64Array) -> Surface:
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
    faces = np.concatenate([joined_rings(count, sides), *caps])
    return Surface(np.concatenate([vertices, path[[0, -1]]]), faces)


def _welded(mesh: Surface) -> NDArray[np.int64]:
    """A number (n,) for each vertex, the same for vertices at the same position."""
    grain = _WELD * max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-9)
    cells = np.round(mesh.vertices / grain).astype(np.int64)
    return np.unique(_numbered(cells), return_inverse=True)[1].ravel()


def _numbered(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """A number (n,) for each row of whole numbers (n, d), in their order; rows sort slowly."""
    low = rows.min(axis=0)
    return np.asarray(np.ravel_multi_index((rows - low).T, np.ptp(rows, axis=0) + 1))


def _around(points: NDArray[np.int64], flat: Float64Array, areas: Float64Array) -> Float64Array:
    """For each corner, the mean normal of the nearly parallel faces at its point."""
    order = np.argsort(points, kind="stable")
    starts = np.searchsorted(points[order], points)
    counts = np.bincount(points)[points]
    mine = np.repeat(np.arange(len(points)), counts)
    within = np.arange(len(mine)) - np.repeat(np.cumsum(counts) - counts, counts)
    other = order[starts[mine] + within]
    near = np.einsum("ij,ij->i", flat[mine], flat[other]) > np.cos(_CREASE)
    return _unit_sums(mine[near], areas[other[near]], len(points))


class Layer(StrEnum):
    """Surfaces that are shown and hidden together."""

    ARM = "arm"
    DEMONSTRATIONS = "demonstrations"
    OBSTACLES = "obstacles"
    PATH = "path"
    MODES = "other modes"
    SPREAD = "uncertainty"
    START = "start"
    GOAL = "goal"
    VIA = "via points"
    PLANNED = "planned arm"


# Layers whose surfaces have no creases.
_SMOOTH = frozenset(Layer) - {Layer.ARM, Layer.OBSTACLES, Layer.PLANNED}
# A screen shows at most 60 frames per second, and a long motion is shown with fewer.
_FRAME_RATE = 60.0
_MAX_FRAMES = 1200


@dataclass(frozen=True, eq=False)
class Item(ShortRepr):
    """One surface."""

    name: str  # unique in its layer
    layer: str  # one of the layers above
    mesh: Surface  # in the frame of its link, or of the arm's base
    colour: Colour  # red, green, blue in [0, 1]
    opacity: float = 1.0  # in [0, 1]
    link: int | None = None  # index of the link that carries it; None if it stands still

    def shaded(self) -> tuple[Surface, Float64Array]:
        """Its surface, with separate vertices at creases, and unit normals (n, 3)."""
        return smooth(self.mesh) if self.layer in _SMOOTH else creased(self.mesh)


@dataclass(frozen=True, eq=False)
class Animation(ShortRepr):
    """Surfaces and the motion of the links that carry some of them."""

    links: tuple[str, ...]  # their names
    times: Float64Array  # (n,), s, from 0. Between them, poses are interpolated
    positions: Float64Array  # of the links in the frame of the arm's base, (n, links, 3), m
    orientations: Float64Array  # of the links in that frame, (n, links, 4), w, x, y, z
    items: tuple[Item, ...] = field(repr=False)  # the surfaces
    tip: int | None = None  # index of the link at the arm's tip
    readouts: dict[str, Any] | None = None  # figures at the times; see `readouts`
    remarks: tuple[str, ...] = ()  # on missing parts, such as a mesh file that is not there

    def ball(self) -> tuple[Float64Array, float]:
        """Centre (3,) and radius, m, of a ball around all surfaces and their motion."""
        still = [item.mesh.vertices for item in self.items if item.link is None]
        frames = {0, len(self.times) // 2, len(self.times) - 1}
        boxes = {item.mesh: _box(item.mesh) for item in self.items if item.link is not None}
        moving = [self._at(item, boxes, frame) for item in self.items for frame in frames]
        points = np.concatenate([self.positions.reshape(-1, 3), *still, *moving])
        lower, upper = points.min(axis=0), points.max(axis=0)
        return 0.5 * (lower + upper), max(0.5 * float(np.linalg.norm(upper - lower)), 0.1)

    def _at(self, item: Item, boxes: Mapping[Surface, Float64Array], frame: int) -> Float64Array:
        """The corners (8, 3) of the box around a moving surface at one sample."""
        if item.link is None:
            return np.zeros((0, 3))
        rotation = rotations.to_matrix(self.orientations[frame, item.link][None])[0]
        return np.asarray(boxes[item.mesh] @ rotation.T + self.positions[frame, item.link])


def _box(mesh: Surface) -> Float64Array:
    """The corners (8, 3) of the box around a surface."""
    reach = np.stack([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    return np.stack(np.meshgrid(*reach.T), axis=-1).reshape(-1, 3)


def sampled(arm: Arm, joints: JointTrajectory | None) -> JointTrajectory:
    """A motion at no more samples than a screen shows."""
    if joints is None:
        return JointTrajectory(np.zeros(1), arm._chain.middle[None], joint_names=arm.joint_names)
    joints = in_order(joints, arm.joint_names, "joints")
    wanted = min(int(joints.duration * _FRAME_RATE) + 2, _MAX_FRAMES)
    if len(joints.times) <= wanted:
        return joints
    times = np.linspace(joints.times[0], joints.times[-1], wanted)
    columns = [np.interp(times, joints.times, column) for column in joints.positions.T]
    return JointTrajectory(times, np.column_stack(columns), joint_names=arm.joint_names)


def link_motion(arm: Arm, q: Float64Array) -> tuple[tuple[str, ...], Float64Array, Float64Array]:
    poses = link_poses(arm, q)
    positions = np.stack([position for _, position in poses.values()], axis=1)
    matrices = np.concatenate([matrix for matrix, _ in poses.values()])
    orientations = rotations.from_matrix(matrices).reshape(len(poses), len(q), 4)
    return tuple(poses), positions, np.stack([*map(rotations.align_signs, orientations)], axis=1)
