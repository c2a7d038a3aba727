"""The third kind of path: the way that the demonstrations predict, and detours in its tube.

Where no obstacle slows the wave down, the quickest path in a thin tube is the middle of the tube:
the way is followed as it is, without short cuts where it meets itself. Around obstacles the wave
looks for a path in a tube as wide as the detour may become. Where obstacles block the way and
another one was shown too, that one is taken before untaught ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.models.marching import mean_path
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.extent import grid_over
from leadthrough.models.marching.hindrance import hindered_field
from leadthrough.models.marching.mean_path import MeanPath
from leadthrough.models.marching.query import Query
from leadthrough.models.marching.route import CELLS_PER_KNOT, Route, route_along
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.band import quickest
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_field import SpeedField, TubeField
from leadthrough.planning.walls import Walls
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Shape

# Details of a predicted way that are shorter than this many radii are tremor, not shape.
_KNOTS = 1.6


def along_mean(faced: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The demonstrations' mean path, with the quickest detours around obstacles."""
    blocked: list[MeanPath] = []
    for mean in mean_path.ways(faced, query.start, query.goal):
        if not _hits(mean.path, query.obstacles):
            return _through(mean, faced, query, scales)
        blocked.append(mean)
    return _quickest_of([_attempt(mean, faced, query, scales) for mean in blocked])


def _quickest_of(attempts: Sequence[Route | NoPath]) -> Route:
    """The route of least travel time."""
    found = [each for each in attempts if isinstance(each, Route)]
    if not found:
        (first, *_) = (each for each in attempts if isinstance(each, NoPath))
        raise first
    return min(found, key=lambda route: route.travel_time)


def _attempt(
    mean: MeanPath, faced: Sequence[Experience], query: Query, scales: Scales
) -> Route | NoPath:
    try:
        return _through(mean, faced, query, scales)
    except NoPath as error:
        return error


def _hits(path: Float64Array, obstacles: Sequence[Shape]) -> bool:
    """Whether a path (n, d) runs into an obstacle between its ends, which cannot be moved."""
    points = np.zeros((len(path), 3))
    points[:, : path.shape[1]] = path
    return any(bool((obstacle.distance(points) <= 0.0).any()) for obstacle in obstacles)


def _through(mean: MeanPath, faced: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The route along one way, around obstacles."""
    way = mean.path
    if scales.workspace is not None:
        way = np.clip(way, *scales.workspace)  # start and goal decide whether that is an error
        way[[0, -1]] = query.ends
    knot_spacing = _KNOTS * scales.radius
    grid, scales = grid_over([way], query.obstacles, scales)
    path = _along_tube(way, grid, query.obstacles, scales)
    if path is not way:
        knot_spacing = CELLS_PER_KNOT * float(grid.spacing.max())
    chosen = mean.weights > 0.0
    used = tuple(each for each, wanted in zip(faced, chosen, strict=True) if wanted)
    weights = np.ones(len(used))  # whose start is nearest says nothing about the pace
    return route_along(
        path,
        _tube(way, grid, query.obstacles, scales),
        knot_spacing=knot_spacing,
        used=used,
        weights=weights,
        method="mean_path",
        region=mean.region if path is way else None,  # a detour needs its room
    )


def _along_tube(
    mean: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> Float64Array:
    """A mean path with detours through its tube; itself where there is none."""
    if not obstacles:
        return mean
    most = scales.saturation if scales.obstacle_map == "minimum" else 1.0
    passed, of = np.unique(grid.numbers_of(grid.cells_of(mean)), return_inverse=True)
    beside = Walls(grid, obstacles).distances(passed, scales.clearance) / scales.clearance
    influenced = beside[of] < most
    if not influenced.any():
        return mean
    try:
        parts = [
            _detour(stretch, grid, obstacles, scales) if blocked else stretch
            for stretch, blocked in _stretches(mean, influenced)
        ]
    except NoPath:
        # An end of a detour may be enclosed although start and goal are not.
        parts = [quickest(_tube(mean, grid, obstacles, scales), mean[0], mean[-1])]
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def _detour(
    stretch: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales
) -> Float64Array:
    """The quickest path from end to end of a stretch."""
    # As wide a tube as the detour may become: it leaves and rejoins the path gently.
    wide = replace(scales, radius=0.5 * float(arc_length(stretch)[-1]))
    return quickest(_tube(stretch, grid, obstacles, wide), stretch[0], stretch[-1])


def _tube(path: Float64Array, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> SpeedField:
    """Speeds in a tube, and a whole clearance about obstacles: their product, or eq. 7."""
    free = TubeField(
        grid, [path], [1.0], area_of_influence=scales.radius, saturation=scales.saturation
    )
    return hindered_field(free, obstacles, scales, band=1.0)


def _stretches(
    path: Float64Array, influenced: NDArray[np.bool_]
) -> list[tuple[Float64Array, bool]]:
    """Consecutive parts of a path (n, d) and whether each is a detour around an obstacle."""
    blocked = np.zeros(len(path), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], influenced, [0]])))
    for first, end in edges.reshape(-1, 2):
        extra = (end - first + 1) // 2
        blocked[max(first - extra, 0) : end + extra] = True
    changes = np.flatnonzero(np.diff(blocked)) + 1
    bounds = [0, *(int(change) for change in changes), len(path) - 1]
    return [
        (path[a : b + 1], bool(blocked[a])) for a, b in pairwise(bounds) if b > a or len(path) == 1
    ]
