"""Fast Marching Learning: demonstrations become a speed map, a wave in it gives the path.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1, eqs. 6 and 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput, NoPath
from leadthrough.models.phase import mean_progress, progress_at
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.planning.arrival import arrival_times
from leadthrough.planning.descent import descend
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import add_obstacles, experience_map
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.preprocess.smooth import smooth_path
from leadthrough.shapes import Shape

# Shares of the demonstrations' mean length, so that the unit of the data does not matter.
_AREA_OF_INFLUENCE = 0.02
_CELLS_PER_AREA = 5.0
# Free space around everything, as a share of the extent: room to walk around an obstacle.
_MARGIN = 0.25
# Grid noise is shorter than this; the shapes of demonstrations are not.
_CELLS_PER_KNOT = 4.0
# Found on human handwriting: between isochrony (0) and constant speed (1).
_DURATION_EXPONENT = 0.25


@dataclass(frozen=True)
class FastMarching:
    """Fast Marching Learning of point-to-point motions in two or three dimensions.

    area_of_influence: radius of the tube around the demonstrations in their unit, > 0; by
    default 0.02 of their mean length. saturation: speed outside the tubes, in (0, 1]; small
    values follow the demonstrations closely, large ones cut corners. resolution: edge of a cell
    in the same unit, > 0; by default a fifth of the area of influence.
    """

    area_of_influence: float | None = None
    saturation: float = 0.02
    resolution: float | None = None

    def __post_init__(self) -> None:
        check.number(self.saturation, "saturation", above=0.0, at_most=1.0)
        for name in ("area_of_influence", "resolution"):
            if getattr(self, name) is not None:
                check.number(getattr(self, name), name, above=0.0)

    def fit(self, demonstrations: Sequence[Demonstration]) -> FastMarchingSkill:
        """A skill from demonstrations that hold a Trajectory of two or three dimensions each.

        Raises InvalidInput for other motions, FitError where nothing can be learned.
        """
        motions = _trajectories(demonstrations)
        paths = tuple(motion.positions for motion in motions)
        lengths = np.array([arc_length(path)[-1] for path in paths])
        if not lengths.all():
            raise FitError(f"demonstrations: number {int(np.argmin(lengths))} does not move")
        area = self.area_of_influence or _AREA_OF_INFLUENCE * float(lengths.mean())
        return FastMarchingSkill(
            experience=paths,
            durations=np.array([motion.duration for motion in motions]),
            progress=mean_progress([motion.times for motion in motions], paths),
            area_of_influence=area,
            saturation=self.saturation,
            resolution=self.resolution or area / _CELLS_PER_AREA,
        )


@dataclass(frozen=True, eq=False)
class FastMarchingSkill:
    """What was learned; made by `FastMarching.fit`.

    experience: paths, each (n, d). durations: (k,) s of the demonstrations. progress: (m,) share
    of the path covered at evenly spaced normalised times. The rest as in `FastMarching`.
    """

    experience: tuple[Float64Array, ...]
    durations: Float64Array
    progress: Float64Array
    area_of_influence: float
    saturation: float
    resolution: float
    grid: Grid = field(init=False)
    velocity_map: Float64Array = field(init=False)

    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration", "obstacles"})

    def __post_init__(self) -> None:
        object.__setattr__(self, "grid", self._grid_over(()))
        object.__setattr__(self, "velocity_map", self._experience_map(self.grid))
        self.velocity_map.setflags(write=False)

    @property
    def dimensions(self) -> int:
        """2 or 3."""
        return int(self.experience[0].shape[1])

    @property
    def start(self) -> Float64Array:
        """(d,) centroid of the demonstrations' first points."""
        return np.asarray(np.mean([path[0] for path in self.experience], axis=0))

    @property
    def goal(self) -> Float64Array:
        """(d,) centroid of the demonstrations' last points, the wave's source."""
        return np.asarray(np.mean([path[-1] for path in self.experience], axis=0))

    def generate(
        self,
        *,
        start: Any = None,
        goal: Any = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> Trajectory:
        """A motion from start to goal that follows the demonstrations and avoids obstacles.

        start, goal: (d,), by default the centroids of the demonstrations' ends. duration: s, > 0,
        by default theirs, adapted to the path's length. dt: s, upper bound of the sampling step.
        obstacles: shapes in the demonstrations' frame; a drawing of two dimensions lies in the
        plane z = 0. The motion starts and ends at rest, with the demonstrations' mean progress
        along the path. Raises InvalidInput, NoPath.
        """
        first = self._point(start, "start", self.start)
        last = self._point(goal, "goal", self.goal)
        check.number(dt, "dt", above=0.0)
        if duration is not None:
            check.number(duration, "duration", above=0.0)
        path = self.plan(first, last, obstacles)
        return self._timed(path, duration, dt)

    def plan(
        self, start: Float64Array, goal: Float64Array, obstacles: Sequence[Shape] = ()
    ) -> Float64Array:
        """The path (n, d) from start to goal, (d,) each, without a time law. Raises NoPath."""
        grid = self._grid_over((start, goal))
        speed = add_obstacles(
            self._experience_map(grid),
            grid,
            obstacles,
            area_of_influence=self.area_of_influence,
        )
        start_cell, goal_cell = grid.cells_of(np.stack([start, goal]))
        for name, point, cell in (("start", start, start_cell), ("goal", goal, goal_cell)):
            if speed[tuple(cell)] == 0.0:
                raise NoPath(f"{name}: {point} lies in an obstacle", reason=f"{name}_in_wall")
        arrival = arrival_times(speed, goal_cell, spacing=grid.spacing)
        if np.isinf(arrival[tuple(start_cell)]):
            raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
        path = descend(arrival, grid, start, goal)
        walls = speed == 0.0
        return smooth_path(
            path,
            knot_spacing=_CELLS_PER_KNOT * self.resolution,
            accept=lambda points: not walls[tuple(grid.cells_of(points).T)].any(),
        )

    def kappa(self, path: Any) -> float:
        """Mean of the velocity map over a path (n, d), eq. 6: 1 deep in the experience.

        Never below the saturation. Raises InvalidInput, also for a path that leaves the map.
        """
        points = check.array(path, "path", shape=("n", self.dimensions))
        if len(points) == 0:
            raise InvalidInput("path: expected at least one point, got none")
        return float(self.velocity_map[tuple(self.grid.cells_of(points).T)].mean())

    def _point(self, value: Any, name: str, default: Float64Array) -> Float64Array:
        return default if value is None else check.array(value, name, shape=(self.dimensions,))

    def _grid_over(self, points: Sequence[Float64Array]) -> Grid:
        everything = np.concatenate([*self.experience, *(point[None] for point in points)])
        extent = float(np.ptp(everything, axis=0).max())
        margin = max(_MARGIN * extent, 2.0 * self.area_of_influence)
        return Grid.covering(everything, margin=margin, spacing=self.resolution)

    def _experience_map(self, grid: Grid) -> Float64Array:
        return experience_map(
            grid,
            self.experience,
            area_of_influence=self.area_of_influence,
            saturation=self.saturation,
        )

    def _timed(self, path: Float64Array, duration: float | None, dt: float) -> Trajectory:
        length = float(arc_length(path)[-1])
        total = duration or self._duration_of(length)
        times = np.linspace(0.0, total, int(np.ceil(total / dt)) + 1)
        if length == 0.0:
            return Trajectory(times, np.repeat(path[:1], len(times), axis=0))
        even = by_arc_length(path, len(path))
        curve = CubicSpline(np.linspace(0.0, 1.0, len(even)), even)
        return Trajectory(times, curve(progress_at(self.progress, times / total)))

    def _duration_of(self, length: float) -> float:
        """Longer paths take longer, but less than in proportion, as in human movements."""
        lengths = np.array([arc_length(path)[-1] for path in self.experience])
        return float(np.median(self.durations * (length / lengths) ** _DURATION_EXPONENT))


def _trajectories(demonstrations: Sequence[Demonstration]) -> list[Trajectory]:
    if isinstance(demonstrations, Demonstration):
        raise InvalidInput("demonstrations: expected a sequence, got a single Demonstration")
    motions = []
    for i, demonstration in enumerate(demonstrations):
        motion = getattr(demonstration, "motion", None)
        if not isinstance(motion, Trajectory):
            got = type(motion if motion is not None else demonstration).__name__
            raise InvalidInput(f"demonstrations[{i}]: expected one with a Trajectory, got {got}")
        if len(motion.times) < 2:
            raise FitError(f"demonstrations[{i}]: has a single sample, needs at least two")
        motions.append(motion)
    if not motions:
        raise FitError("demonstrations: got none, needs at least one")
    dimensions = {motion.positions.shape[1] for motion in motions}
    if len(dimensions) > 1 or not dimensions <= {2, 3}:
        raise InvalidInput(
            f"demonstrations: expected all in two or all in three dimensions, got {dimensions}"
        )
    return motions
