"""The five experiments of Prados et al. 2023, section 4.2, as far as the paper describes them.

The paper gives start and goal, the cells (150^3 of 1 cm), kappa and the kind of demonstrations. The
following is assumed here, all in the workspace frame of the paper, x, y and z up, in m:

- The demonstrations come from `demonstrator`, five per experiment, with ends scattered by 3 cm:
  from start to goal (1, 3), from start to goal over the box (2), up and down at five places 10 cm
  beside the straight line, alternating sides (4), random within 15 cm of the straight line (5).
- The top of the table is at z = 0.62, below the lowest end of all paths and its area of influence.
  The table extends under the whole workspace.
- The box stands on the table. In experiment 2 it stands between start and goal. In experiment 3 it
  appears across the demonstrations, which are those of experiment 1, and is so wide that no path
  passes it inside their tube.
- Experiments 1 and 4 are 1.67 m apart, so that one base position cannot serve both. The UR3 stands
  upright at the position stated for each, where a way for the whole arm exists: in experiment 3 on
  a column, as its forearm has to pass over the box. Its tip tool0 follows the path with free
  orientation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.shapes import Box, Shape
from leadthrough_studies.demonstrator import Teaching, guide, wander

Point = tuple[float, float, float]

WORKSPACE = 1.5  # m, edge of the cube
TABLE_TOP = 0.62
DEMONSTRATIONS = 5
_REACH_OF_WANDERING = 0.15
_BESIDE_THE_WAY = 0.10


@dataclass(frozen=True)
class Setup:
    """An experiment.

    Attributes:
        title: short description.
        start: start of the path, m.
        goal: goal of the path, m.
        base: position of the UR3's base, m.
        shown: kind of demonstrations: "reach", "over", "vertical" or "wander".
        kappa: the paper's value, if it prints one.
        box: size and centre of the box, m, if there is one.
    """

    title: str
    start: Point
    goal: Point
    base: Point
    shown: str
    kappa: float | None
    box: tuple[Point, Point] | None = None

    def boxes(self) -> list[Box]:
        """The box in a list, which is empty if there is none."""
        if self.box is None:
            return []
        size, position = self.box
        return [Box(np.array(size), np.array(position))]

    def obstacles(self) -> list[Shape]:
        """The table, and the box if there is one."""
        return [table(), *self.boxes()]

    def around_the_arm(self) -> list[Shape]:
        """The same in the frame of the arm's base."""
        base = np.array(self.base)
        return [each.at(each.position - base) for each in self.obstacles()]


_BASE_BY_THE_TABLE: Point = (0.05, 1.04, 0.85)
_BASE_ON_A_COLUMN: Point = (0.0, 1.02, 1.18)

SETUPS = {
    1: Setup("empty", (0.30, 1.30, 1.10), (0.40, 0.78, 0.87), _BASE_BY_THE_TABLE, "reach", 0.635),
    2: Setup(
        "box known while teaching", (0.30, 1.30, 1.10), (0.40, 0.78, 0.87), _BASE_BY_THE_TABLE,
        "over", 0.7894, ((0.14, 0.10, 0.30), (0.37, 0.98, 0.77)),
    ),
    3: Setup(
        "box appears later", (0.28, 1.30, 1.00), (0.25, 0.87, 0.89), _BASE_ON_A_COLUMN,
        "reach", 0.2096, ((0.26, 0.10, 0.48), (0.34, 1.08, 0.86)),
    ),
    4: Setup(
        "segregated demonstrations", (1.40, 0.05, 1.20), (1.00, 0.55, 0.70), (1.28, 0.53, 0.73),
        "vertical", 0.105,
    ),
    5: Setup(
        "useless demonstrations", (0.40, 0.87, 0.90), (0.40, 0.78, 0.87), _BASE_BY_THE_TABLE,
        "wander", None,
    ),
}  # fmt: skip


def table() -> Box:
    """The table, from the floor to its top."""
    size = np.array([WORKSPACE, WORKSPACE, TABLE_TOP])
    return Box(size, 0.5 * size)


def demonstrations(number: int, teaching: Teaching, seed: int) -> list[Demonstration[Trajectory]]:
    """The demonstrations of an experiment; experiments 1 and 3 have the same."""
    kind = SETUPS[number].shown
    setup = SETUPS[1] if kind == "reach" else SETUPS[number]
    rng = np.random.default_rng([seed, 1 if kind == "reach" else number])
    return [_shown(kind, setup, i, teaching, rng) for i in range(DEMONSTRATIONS)]


def _shown(
    kind: str, setup: Setup, index: int, teaching: Teaching, rng: np.random.Generator
) -> Demonstration[Trajectory]:
    start, goal = np.array(setup.start), np.array(setup.goal)
    if kind == "vertical":
        way = goal - start
        beside = np.array([way[1], -way[0], 0.0]) / np.hypot(way[0], way[1])
        side = _BESIDE_THE_WAY if index % 2 else -_BESIDE_THE_WAY
        place = start + (index + 1) / (DEMONSTRATIONS + 1) * way + side * beside
        ends = np.tile(place, (2, 1))
        ends[:, 2] = (start[2], goal[2]) if index % 2 else (goal[2], start[2])
        return guide(ends, teaching, rng)
    if kind == "wander":
        middle = 0.5 * (start + goal)
        reach = np.full(3, _REACH_OF_WANDERING)
        return wander(middle - reach, middle + reach, teaching, rng)
    via = [] if kind == "reach" else [_above(setup)]
    return guide(np.array([start, *via, goal]), teaching, rng)


def _above(setup: Setup) -> Float64Array:
    (box,) = setup.boxes()
    above = np.array(box.position)
    above[2] += 0.5 * box.size[2] + 0.10
    return above
