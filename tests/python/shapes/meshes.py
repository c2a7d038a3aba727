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
