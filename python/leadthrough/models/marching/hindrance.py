"""How obstacles enter the maps of Fast Marching Learning, and how the wave passes them."""

from __future__ import annotations

from collections.abc import Sequence

from leadthrough.models.marching.scales import Scales
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_field import (
    FreeField,
    HinderedField,
    PassableField,
    SaturatedField,
    SpeedField,
)
from leadthrough.planning.speed_map import (
    Speeds,
    add_obstacles,
    add_passable_obstacles,
    add_saturated_obstacles,
)
from leadthrough.planning.walls import Walls
from leadthrough.shapes import Shape

OBSTACLE_MAPS = ("product", "minimum")

# Width of the band in which the product slows the wave down, as a fraction of the clearance. A path
# that has to pass through a wider one beside its tube would rather leave the tube for a short cut.
BAND = 0.5
# How far ways round an obstacle reach from where it stands in a tube, in clearances: the tube goes
# on beside small boxes, and not along a whole table that it touches.
REACH = 2.0


def hindered(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """A map of tubes with obstacles, as `FastMarching.obstacle_map` says."""
    if scales.obstacle_map == "minimum":
        return add_saturated_obstacles(
            speed,
            grid,
            obstacles,
            area_of_influence=scales.clearance,
            saturation=scales.saturation,
        )
    return add_obstacles(speed, grid, obstacles, area_of_influence=BAND * scales.clearance)


def passable(speed: Speeds, grid: Grid, obstacles: Sequence[Shape], scales: Scales) -> Speeds:
    """The map of `hindered` that paths are planned in: the product has ways round obstacles."""
    if scales.obstacle_map == "minimum":
        return hindered(speed, grid, obstacles, scales)
    return add_passable_obstacles(
        speed,
        grid,
        obstacles,
        band=BAND * scales.clearance,
        saturation=scales.saturation,
        reach=REACH * scales.clearance,
    )


def hindered_field(
    free: SpeedField, obstacles: Sequence[Shape], scales: Scales, *, band: float = BAND
) -> SpeedField:
    """The speeds of `hindered`, where they are asked for."""
    if not obstacles:
        return free
    walls = Walls(free.grid, obstacles)
    if scales.obstacle_map == "minimum":
        return SaturatedField(
            free, walls, area_of_influence=scales.clearance, saturation=scales.saturation
        )
    return HinderedField(free, walls, area_of_influence=band * scales.clearance)


def passable_field(free: FreeField, obstacles: Sequence[Shape], scales: Scales) -> SpeedField:
    """The speeds of `passable`, where they are asked for."""
    if not obstacles or scales.obstacle_map == "minimum":
        return hindered_field(free, obstacles, scales)
    return PassableField(
        free,
        Walls(free.grid, obstacles),
        band=BAND * scales.clearance,
        reach=REACH * scales.clearance,
    )
