"""The quickest path past a box, marched in a band, against maps and marches of all cells.

The same path in ever more room: the peer's cost grows with the map, ours with the path.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from frame import Benchmark

import leadthrough as lt
from leadthrough.check import Float64Array
from leadthrough.planning import Grid, arrival_times, descend
from leadthrough.planning.speed_map import (
    ObstacleField,
    TubeField,
    Walls,
    add_obstacles,
    quickest,
)
from leadthrough.preprocess import frechet_distance
from leadthrough.preprocess.resample import by_arc_length

RADIUS, SATURATION, CLEARANCE = 0.2, 0.02, 0.012  # m, 1, m
TOLERANCE = 0.5  # cells
SAMPLES = 1000


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for a way of 0.6 m in 2-D and 3-D, in little room and in much."""
    for dimensions, spacing in ((2, 0.004 if quick else 0.002), (3, 0.012 if quick else 0.006)):
        for room in (0.1, 0.3):
            yield _past_a_box(dimensions, spacing, room)


def _past_a_box(dimensions: int, spacing: float, room: float) -> Benchmark:
    u = np.linspace(0.0, 1.0, 200)[:, None]
    way = np.hstack([0.6 * u, 0.1 * np.sin(np.pi * u), 0.1 * u])[:, :dimensions]
    middle = np.zeros(3)
    middle[:dimensions] = way[100]
    obstacles = [lt.Box((0.06, 0.06, 0.3), middle)]
    grid = Grid.covering(way, margin=room, spacing=spacing)
    cells = np.arange(np.prod(grid.shape))
    tube = {"area_of_influence": RADIUS, "saturation": SATURATION}

    def in_band() -> Float64Array:
        free = TubeField(grid, [way], [1.0], **tube)
        field = ObstacleField(free, Walls(grid, obstacles), area_of_influence=CLEARANCE)
        return quickest(field, way[0], way[-1])

    def in_all_cells() -> Float64Array:
        free = TubeField(grid, [way], [1.0], **tube).at(cells).reshape(grid.shape)
        speed = add_obstacles(free, grid, obstacles, area_of_influence=CLEARANCE)
        start, goal = grid.cells_of(way[[0, -1]])
        arrival = arrival_times(speed, goal, spacing=grid.spacing, order=2, stop=start)
        return descend(arrival, grid, way[0], way[-1])

    def apart(one: Float64Array, other: Float64Array) -> float:
        even = (by_arc_length(each, SAMPLES) for each in (one, other))
        return frechet_distance(*even) / spacing

    size = " x ".join(map(str, grid.shape))
    return Benchmark(
        name=f"path past a box, {size} cells",
        ours=in_band,
        peer=in_all_cells,
        peer_name="full march",
        error=apart,
        tolerance=TOLERANCE,
    )
