"""A policy from a field of arrival times: where to go from any place, without planning again.

Source: Prados et al. 2023, section 3.7: the field is the control policy of the task.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.extent import grid_over
from leadthrough.models.marching.hindrance import hindered
from leadthrough.models.marching.scales import Scales
from leadthrough.planning.arrival import arrival_times
from leadthrough.planning.descent import direction
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import experience_map
from leadthrough.shapes import Shape

# Room for a policy around its goal, as a fraction of the demonstrations' extent.
_PUSHED = 1.25


@dataclass(frozen=True, eq=False)
class Policy:
    """Velocities that lead to a goal from wherever the tool was pushed.

    Attributes:
        grid: cells of the field.
        arrival: times in each cell, marched from the goal.
        goal: (d,).
        speed: far from the goal, in the grid's unit per second.
        slowing: distance to the goal within which the speed falls linearly to zero.
    """

    grid: Grid
    arrival: Float64Array
    goal: Float64Array
    speed: float
    slowing: float

    def __call__(self, position: ArrayLike) -> Float64Array:
        """The velocity (d,) at a position, in the unit of the grid per second; zero at the goal.

        Args:
            position: (d,).

        Raises:
            InvalidInput: if the position is of another shape.
            NoPath: outside the grid and in obstacles.
        """
        point = check.array(position, "position", shape=(self.grid.dimensions,))
        left = float(np.linalg.norm(self.goal - point))
        if left <= float(self.grid.spacing.max()):  # the field means nothing within the goal's cell
            ahead = self.goal - point
            return np.asarray(ahead * (self.speed / self.slowing))
        ahead = direction(self.arrival, self.grid, point[None])[0]
        return np.asarray(ahead * self.speed * min(left / self.slowing, 1.0))


def field_to(
    known: Sequence[Experience], goal: Float64Array, obstacles: Sequence[Shape], scales: Scales
) -> tuple[Grid, Float64Array]:
    """The field of a wave that starts at a goal, in the map of all demonstrations.

    There is room in it for a tool that was pushed away.

    Args:
        known: demonstrations and learned paths, at least one.
        goal: (d,).
        obstacles: shapes in the same frame.
        scales: of the map.

    Returns:
        The grid, and arrival times in its cells.

    Raises:
        InvalidInput: if the goal lies outside a workspace that was set.
        NoPath: if the goal lies in an obstacle.
    """
    paths = [each.way for each in known]
    room = _PUSHED * float(np.ptp(np.concatenate(paths), axis=0).max())
    around = np.concatenate([goal[None] - room, goal[None] + room, *paths])
    if scales.workspace is not None:
        around = np.concatenate([goal[None], *paths])
    grid, scales = grid_over([around], obstacles, scales)
    speed = experience_map(
        grid, paths, area_of_influence=scales.radius, saturation=scales.saturation
    )
    speed = hindered(speed, grid, obstacles, scales)
    cell = grid.cells_of(goal[None])
    if speed[tuple(cell[0])] == 0.0:
        raise NoPath(f"goal: {goal} lies in an obstacle", reason="goal_in_wall")
    return grid, arrival_times(speed, cell, spacing=grid.spacing)
