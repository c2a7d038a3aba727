"""How obstacles slow the wave down in the maps of Fast Marching Learning."""

from __future__ import annotations

from collections.abc import Sequence

from leadthrough.models.marching.scales import Scales
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import Speeds, add_obstacles, add_saturated_obstacles
from leadthrough.shapes import Shape

OBSTACLE_MAPS = ("product", "minimum")

# Width of the band in which the product slows the wave down, as a fraction of the clearance. A path
# that has to pass through a wider one beside its tube would rather leave the tube for a short cut.
BAND = 0.5


def hindered(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """A map of tubes with obstacles, as `FastMarching.obstacle_map` says.

    Args:
        speed: the map without obstacles, of grid.shape.
        grid: of the map.
        obstacles: in the grid's unit.
        scales: of the map.
    """
    if scales.obstacle_map == "minimum":
        return add_saturated_obstacles(
            speed,
            grid,
            obstacles,
            area_of_influence=scales.clearance,
            saturation=scales.saturation,
        )
    return add_obstacles(speed, grid, obstacles, area_of_influence=BAND * scales.clearance)
