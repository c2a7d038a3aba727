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


def bin_of(size, wall, radius=0.0, count=1):
    """Corners and faces of an open box of one surface, its edges rounded by `count` points."""
    width, depth, height = size
    slopes = np.linspace(0.0, np.pi / 2, count) if count > 1 else [0.0]
    insets = [wall + radius * (1.0 - np.cos(slope)) for slope in slopes]
    heights = [wall + radius * (1.0 - np.sin(slope)) for slope in slopes]
    insets, heights = [0.0, 0.0, wall, *insets], [0.0, height, height, *heights]
    vertices = []
    for inset, z in zip(insets, heights, strict=True):
        bend = max(radius + wall - inset, 1e-4) if radius else 0.0
        for corner, (x, y) in enumerate([(1, 1), (0, 1), (0, 0), (1, 0)]):
            turns = np.pi / 2 * (corner + np.linspace(0.0, 1.0, count))
            middle = [
                x * width - (2 * x - 1) * (inset + bend),
                y * depth - (2 * y - 1) * (inset + bend),
            ]
            ring = middle + bend * np.column_stack([np.cos(turns), np.sin(turns)])
            vertices += [(*point, z) for point in ring]
    n, last = 4 * count, len(vertices) - 4 * count
    side, inner = np.arange(last), np.arange(1, n - 1)
    after = side - side % n + (side + 1) % n
    faces = [
        np.column_stack([0 * inner, inner + 1, inner]),
        np.column_stack([0 * inner, inner, inner + 1]) + last,
        np.column_stack([side, after, after + n]),
        np.column_stack([side, after + n, side + n]),
    ]
    return np.array(vertices), np.concatenate(faces)
