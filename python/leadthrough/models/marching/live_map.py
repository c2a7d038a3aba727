"""Fast Marching Learning for goals and obstacles that keep moving: tens of milliseconds an answer.

The map of the demonstrations is made once, for a workspace; a query adds its obstacles and marches
no farther than to the start, which is soon reached along the tubes. In such maps that is quicker
than to update a whole field of arrival times: a box on the way changes all times behind it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, NoPath
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.extent import grid_over
from leadthrough.models.marching.hindrance import hindered, passable
from leadthrough.models.marching.route import Route, route_along
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.arrival import arrival_times
from leadthrough.planning.descent import descend
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_field import MapField
from leadthrough.planning.speed_map import experience_map
from leadthrough.shapes import Shape, check_shapes

if TYPE_CHECKING:
    from leadthrough.models.marching.model import FastMarching


class LiveMap:
    """The map of all demonstrations over a workspace; made by `FastMarchingSkill.live_map`."""

    def __init__(self, known: Sequence[Experience], scales: Scales) -> None:
        paths = [each.way for each in known]
        self._known = tuple(known)
        self._grid, self._scales = grid_over(paths, (), scales)
        speed = experience_map(
            self._grid,
            paths,
            area_of_influence=self._scales.radius,
            saturation=self._scales.saturation,
        )
        self._free = speed.astype(np.float32)

    @property
    def grid(self) -> Grid:
        """The cells of the map."""
        return self._grid

    def route(self, start: Float64Array, goal: Float64Array, obstacles: Sequence[Shape]) -> Route:
        """The quickest path between two points around obstacles, in the map of the method "map"."""
        ends = [
            check.array(value, name, shape=(self._grid.dimensions,))
            for value, name in ((start, "start"), (goal, "goal"))
        ]
        for end, name in zip(ends, ("start", "goal"), strict=True):
            if not self._grid.contains(end[None])[0]:
                raise InvalidInput(f"{name}: expected a point inside the workspace, got {end}")
        shapes = check_shapes(obstacles)
        around = passable(self._free, self._grid, shapes, self._scales)
        path = _quickest(self._grid, around, *ends)
        speed = MapField(self._grid, hindered(self._free, self._grid, shapes, self._scales))
        used = tuple(each.facing(ends[0], ends[1]) for each in self._known)
        return route_along(path, speed, used=used, weights=np.ones(len(used)), method="map")


def _quickest(
    grid: Grid, speed: NDArray[np.float32], start: Float64Array, goal: Float64Array
) -> Float64Array:
    """The path (n, d) of least time in a map of speeds, at first order."""
    start_cell, goal_cell = grid.cells_of(np.stack([start, goal]))
    for name, point, cell in (("start", start, start_cell), ("goal", goal, goal_cell)):
        if speed[tuple(cell)] == 0.0:
            raise NoPath(f"{name}: {point} lies in an obstacle", reason=f"{name}_in_wall")
    arrival = arrival_times(
        speed, goal_cell, spacing=grid.spacing, order=1, dtype=np.float32, stop=start_cell
    )
    if np.isinf(arrival[tuple(start_cell)]):
        raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
    return descend(arrival, grid, start, goal)


def live_model(
    model: FastMarching, workspace: ArrayLike, cells: int, dimensions: int
) -> FastMarching:
    """The settings of a live map, from those of a skill and the arguments of its `live_map`."""
    corners = check.array(workspace, "workspace", shape=(2, dimensions))
    count = check.integer(cells, "cells", at_least=1000)
    lengths = np.maximum(corners[1] - corners[0], 0.0)
    edge = float((lengths.prod() / count) ** (1.0 / dimensions))
    space = (tuple(corners[0]), tuple(corners[1]))
    return replace(model, method="map", workspace=space, resolution=edge)
