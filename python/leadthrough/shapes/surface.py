"""Triangle meshes: of the surfaces of solids, and around points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array, ShortRepr

_SIDES = 40  # of a surface of revolution
_ARC_STEPS = 12  # of a quarter of a circle
_MAX_DOTS = 4000  # of a cloud; more would make pages slow to load and turn
_IDENTITY = np.eye(3)


@dataclass(frozen=True, eq=False)
class Surface(ShortRepr):
    vertices: Float64Array  # (n, 3), m
    faces: NDArray[np.int64]  # indices of vertices (m, 3), anticlockwise as seen from outside

    def moved(self, position: Float64Array, rotation: Float64Array = _IDENTITY) -> Surface:
        """The surface with each point p moved to rotation p + position, (3, 3) and (3,), m."""
        return Surface(self.vertices @ rotation.T + position, self.faces)

    def moments(self) -> tuple[float, Float64Array, Float64Array]:
        """Volume, m^3, mean (3,), m, and covariance (3, 3), m^2, of the points inside."""
        corners = self.vertices[self.faces]
        six_volumes = np.linalg.det(corners)
        total, sums = six_volumes.sum(), corners.sum(axis=1)
        mean = six_volumes @ sums / (4.0 * total)
        squares = np.einsum("n,ni,nj->ij", six_volumes, sums, sums)
        squares += np.einsum("n,nki,nkj->ij", six_volumes, corners, corners)
        return float(total) / 6.0, mean, squares / (20.0 * total) - np.outer(mean, mean)


def merged(surfaces: Sequence[Surface]) -> Surface:
    if len(surfaces) == 1:
        return surfaces[0]
    offsets = np.cumsum([0, *(len(each.vertices) for each in surfaces[:-1])])
    faces = [each.faces + offset for each, offset in zip(surfaces, offsets, strict=True)]
    return Surface(np.concatenate([each.vertices for each in surfaces]), np.concatenate(faces))


def box(size: Float64Array) -> Surface:
    """A box about the origin, with full edge lengths (3,), m."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    return Surface(0.5 * signs * np.asarray(size), np.array(faces))


def cylinder(radius: float, length: float) -> Surface:
    """A cylinder along z, centred at the origin; lengths in m."""
    half = 0.5 * length
    return _of_revolution([(0.0, -half), (radius, -half), (radius, half), (0.0, half)])


def sphere(radius: float) -> Surface:
    """A ball centred at the origin; radius in m."""
    return capsule(radius, 0.0)


def capsule(radius: float, length: float) -> Surface:
    """A capsule along z, centred at the origin, with the length between its ends' centres, m."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * _ARC_STEPS + 1)
    shift = np.where(angles > 0.0, 0.5 * length, -0.5 * length)
    profile = np.column_stack([radius * np.cos(angles), radius * np.sin(angles) + shift])
    profile[[0, -1], 0] = 0.0
    return _of_revolution(profile)


def dots(points: Float64Array, radius: float) -> Surface:
    """Octahedra around points (n, 3), of many only some of them, m."""
    count = min(len(points), _MAX_DOTS)
    drawn = points[np.linspace(0, len(points) - 1, count).round().astype(np.int64)]
    corners = radius * np.concatenate([np.eye(3), -np.eye(3)])
    sides = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    faces = 6 * np.arange(count)[:, None, None] + np.array(sides)
    return Surface((drawn[:, None] + corners).reshape(-1, 3), faces.reshape(-1, 3))


def circle(count: int) -> Float64Array:
    """Points (count, 2) on the unit circle."""
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def joined_rings(count: int, sides: int) -> NDArray[np.int64]:
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


def _of_revolution(profile: Sequence[tuple[float, float]] | Float64Array) -> Surface:
    """The surface of revolution about z of a profile of radii and heights (n, 2), upwards."""
    radii, heights = np.asarray(profile, dtype=np.float64).T
    rings = np.zeros((len(radii), _SIDES, 3))
    rings[:, :, :2] = radii[:, None, None] * circle(_SIDES)
    rings[:, :, 2] = heights[:, None]
    return _without_slivers(Surface(rings.reshape(-1, 3), joined_rings(len(radii), _SIDES)))


def _without_slivers(surface: Surface) -> Surface:
    """The surface without triangles of no area, as at poles."""
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Surface(surface.vertices, surface.faces[areas > 1e-12 * areas.max()])
