"""Fast Marching Learning for goals and obstacles that keep moving: tens of milliseconds an answer.

The map of the demonstrations is made once, for a workspace; a query adds its obstacles and marches
no farther than to the start, which is soon reached along the tubes. In such maps that is quicker
than to update a whole field of arrival times: a box on the way changes all times behind it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.marching import route
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.route import Route
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import add_obstacles, experience_map
from leadthrough.shapes import Shape, check_shapes


class LiveMap:
    """The map of all demonstrations over a workspace; made by `FastMarchingSkill.live_map`.

    Where `generate` marches at second order and double precision, this does at first order and
    single precision; obstacles are kept clear of just as strictly.

    Args:
        known: demonstrations and learned paths.
        scales: of the map, with the workspace.

    Raises:
        InvalidInput: if a path leaves the workspace.
    """

    def __init__(self, known: Sequence[Experience], scales: Scales) -> None:
        paths = [each.way for each in known]
        self._known = tuple(known)
        self._grid, self._scales = route.grid_over(paths, (), scales)
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
        """The quickest path between two points around obstacles, as by the method "map".

        Args:
            start: (d,).
            goal: (d,).
            obstacles: shapes in the demonstrations' frame.

        Raises:
            InvalidInput: if an end is of another shape, or outside the workspace.
            NoPath: where an end lies in an obstacle, or obstacles separate them.
        """
        ends = [
            check.array(value, name, shape=(self._grid.dimensions,))
            for value, name in ((start, "start"), (goal, "goal"))
        ]
        for end, name in zip(ends, ("start", "goal"), strict=True):
            if not self._grid.contains(end[None])[0]:
                raise InvalidInput(f"{name}: expected a point inside the workspace, got {end}")
        speed = add_obstacles(
            self._free,
            self._grid,
            check_shapes(obstacles),
            area_of_influence=self._scales.clearance,
        )
        path = route.quickest(self._grid, speed, ends[0], ends[1], order=1)
        used = tuple(each.facing(ends[0], ends[1]) for each in self._known)
        return route.route_along(
            path, self._grid, speed, used=used, weights=np.ones(len(used)), method="map"
        )
