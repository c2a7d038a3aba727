"""A policy from a field of arrival times: where to go from any place, without planning again.

Source: Prados et al. 2023, section 3.7: the field is the control policy of the task.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.planning.descent import direction
from leadthrough.planning.grid import Grid


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
