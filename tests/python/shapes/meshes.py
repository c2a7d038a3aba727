"""Meshes of the surfaces of other shapes."""

import numpy as np

import leadthrough as lt


def mesh_of(*solids, place=(0.0, 0.0, 0.0), turn=(1.0, 0.0, 0.0, 0.0)):
    """One mesh of the surfaces of shapes, in one frame, placed as a whole."""
    surfaces = [solid.placed_surface() for solid in solids]
    firsts = np.cumsum([0] + [len(each.vertices) for each in surfaces[:-1]])
    faces = [each.faces + first for each, first in zip(surfaces, firsts, strict=True)]
    return lt.Mesh(
        np.concatenate([each.vertices for each in surfaces]), np.concatenate(faces), place, turn
    )


def bin_of(size, wall):
    """Corners and faces of an open box of one surface, its bottom at z = 0."""
    width, depth, height = size
    sides = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    outer, inner = sides * (width, depth), wall + sides * (width - 2 * wall, depth - 2 * wall)
    rings = [(outer, 0.0), (outer, height), (inner, height), (inner, wall)]
    vertices = np.concatenate([np.column_stack([ring, np.full(4, z)]) for ring, z in rings])
    side, after = np.arange(4), (np.arange(4) + 1) % 4
    faces = [[(0, 2, 1), (0, 3, 2), (12, 13, 14), (12, 14, 15)]]
    for below in (0, 4, 8):
        square = np.column_stack([side, after, after + 4, side + 4]) + below
        faces += [square[:, [0, 1, 2]], square[:, [0, 2, 3]]]
    return vertices, np.concatenate(faces)
