"""Mass properties of solids of uniform density."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.shapes.box import Box
from leadthrough.shapes.mesh import Mesh
from leadthrough.shapes.round import Capsule, Cylinder, Sphere

Solid = Box | Sphere | Capsule | Cylinder | Mesh


def unit_solid(shape: Solid) -> tuple[Float64Array, Float64Array]:
    """Centre (3,), m, and inertia (3, 3) about it, m^2, of a solid of 1 kg, in the base frame."""
    if isinstance(shape, Sphere):
        return shape.position, 0.4 * shape.radius**2 * np.eye(3)
    turn = shape._matrix
    if isinstance(shape, Mesh):
        centre, spread = _of_hulls(shape)
        inertia = np.trace(spread) * np.eye(3) - spread
        return shape.position + turn @ centre, turn @ inertia @ turn.T
    return shape.position, (turn * _moments(shape)) @ turn.T


def _moments(shape: Box | Capsule | Cylinder) -> Float64Array:
    """Principal moments (3,) of a solid about its middle, for a mass of one."""
    if isinstance(shape, Box):
        squares = shape.size**2
        return np.asarray((squares.sum() - squares) / 12.0)
    if isinstance(shape, Capsule):
        return _capsule_moments(shape)
    along = 0.5 * shape.radius**2
    across = shape.length**2 / 12.0 + 0.5 * along
    return np.array([across, across, along])


def _capsule_moments(capsule: Capsule) -> Float64Array:
    """Principal moments (3,) of a cylinder with half balls, for a mass of one."""
    r, length = capsule.radius, capsule.length
    cylinder = length / (length + 4.0 / 3.0 * r)  # its fraction of the volume
    balls = 1.0 - cylinder
    along = cylinder * r**2 / 2.0 + balls * 0.4 * r**2
    across = cylinder * (length**2 / 12.0 + r**2 / 4.0) + balls * (
        0.4 * r**2 + length**2 / 4.0 + 3.0 / 8.0 * length * r
    )
    return np.array([across, across, along])


def _of_hulls(mesh: Mesh) -> tuple[Float64Array, Float64Array]:
    """Mean (3,) and covariance (3, 3) of the points in a mesh's hulls."""
    corners = np.concatenate([part.vertices[part.faces] for part in mesh.parts])
    six_volumes = np.linalg.det(corners)
    sums = corners.sum(axis=1)
    mean = six_volumes @ sums / (4.0 * six_volumes.sum())
    squares = np.einsum("n,ni,nj->ij", six_volumes, sums, sums)
    squares += np.einsum("n,nki,nkj->ij", six_volumes, corners, corners)
    return mean, squares / (20.0 * six_volumes.sum()) - np.outer(mean, mean)
