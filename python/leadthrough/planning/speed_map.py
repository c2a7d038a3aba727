"""Speed maps: where the wave runs fast, a path likes to go.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1 and eq. 7. Distances are exact Euclidean
ones where the paper marches a wave at unit speed; both are the distance to the tube's border.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.planning.distance import distance_transform
from leadthrough.planning.grid import Grid
from leadthrough.planning.obstacles import occupied
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.shapes import Shape


def experience_map(
    grid: Grid, paths: Sequence[Float64Array], *, area_of_influence: float, saturation: float
) -> Float64Array:
    """Speed from saturation, off the paths, to 1, deepest in the tube around them.

    grid covers the paths. paths: each (n, d), in the grid's unit. area_of_influence: radius of
    the tube, same unit. saturation: in (0, 1]. Returns an array of the grid's shape.
    """
    labelled = np.zeros(grid.shape, dtype=bool)
    for path in paths:
        labelled[tuple(grid.cells_of(_dense(path, grid)).T)] = True
    tube = distance_transform(labelled, spacing=grid.spacing) <= area_of_influence
    depth = distance_transform(~tube, spacing=grid.spacing)
    deepest = depth.max()
    if deepest == 0.0 or np.isinf(deepest):  # no experience, or experience everywhere
        return np.full(grid.shape, saturation if deepest == 0.0 else 1.0)
    return np.asarray(saturation + (1.0 - saturation) * depth / deepest)


def add_obstacles(
    speed: Float64Array, grid: Grid, obstacles: Sequence[Shape], *, area_of_influence: float
) -> Float64Array:
    """The speed map with walls (speed 0) at the obstacles and slower cells beside them.

    The speed grows from 0 at an obstacle to its own value one area of influence away, so that a
    path keeps that distance wherever there is room. The paper's eq. 7 takes the smaller of both
    maps, and only below the saturation: that leaves a step in the speed, whose corners the path
    would follow.
    """
    # A path may pass a free cell's corner, half a diagonal from the centre that was tested.
    walls = occupied(grid, obstacles, margin=0.5 * float(np.linalg.norm(grid.spacing)))
    if not walls.any():
        return speed
    distance = distance_transform(walls, spacing=grid.spacing)
    return np.asarray(speed * np.minimum(distance / area_of_influence, 1.0))


def _dense(path: Float64Array, grid: Grid) -> Float64Array:
    """The path sampled finely enough to label every cell it crosses but for clipped corners."""
    if len(path) < 2:
        return path
    steps = int(np.ceil(2.0 * arc_length(path)[-1] / np.min(grid.spacing))) + 1
    return by_arc_length(path, max(steps, 2))
