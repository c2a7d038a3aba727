"""A policy from a field of arrival times: velocities at any position, without planning again.

Source: Prados et al. 2023, section 3.7: the field is the control policy of the task.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, NoPath, ShortRepr
from leadthrough.io import npz
from leadthrough.models import curves
from leadthrough.models.marching.experience import Experience
from leadthrough.motion import lerp
from leadthrough.planning import ArrivalField, Grid, arrival_times, direction
from leadthrough.planning.maps import Scales, grid_over, speeds_along, with_detours
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.shapes import Shape, check_shapes

Times = NDArray[np.float32] | Float64Array

# Room for a policy around its goal, as a fraction of the demonstrations' extent.
_PUSHED = 1.25
# From any point in a barrier into free cells beyond it, in the barrier's half thickness.
_PAST_BARRIER = 4.0
# Ends closer than this fraction of the length count as one position.
_RETURNS = 0.05
_SAMPLES = 1000
_TANGENT = 30  # samples from the start and to the end that give the direction
# Departure and arrival that turn back by more than 120 degrees lie in one tube: no barrier
# separates them.
_MIN_NORMAL = 1.0
# From the start back to the barrier and to the goal, in cells' edges.
_TO_BARRIER, _TO_GOAL = 2.0, 4.0
# Half width: in radii, so that it closes the tube, and as a fraction of length times saturation,
# so that the path past it takes longer than the motion; at most a part of the extent.
_RADII, _LENGTHS, _EXTENT = 2.5, 0.75, 0.25
_STEP = 5  # every fifth of the samples of a demonstration's progress
# People start and end at rest; a policy of the position alone must leave the start.
_MIN_SPEED = 0.1  # of the mean speed
_MAX_STEP = 100.0  # s


@dataclass(frozen=True, eq=False)
class Policy(ShortRepr):
    """Velocities that lead to a goal from wherever the tool was pushed."""

    grid: Grid  # cells of the field
    arrival: Times  # times in each cell, marched from the goal
    goal: Float64Array  # (d,) where the tool comes to rest
    speeds: DemonstratedSpeeds  # speeds that the demonstrations teach
    slowing: float
    barrier: StartBarrier | None  # across the start of a motion that returns to it, or None
    _map: _PolicyMap = field(repr=False)

    def __call__(self, position: ArrayLike) -> Float64Array:
        """Velocity (d,) at a position, or (n, d) at rows; per second, zero at the goal."""
        return self._at_each(self._compiled.velocities, position)

    def step(self, position: ArrayLike, dt: float) -> Float64Array:
        """The position (d,) that the tool reaches from a position within dt s, or rows (n, d)."""
        span = check.number(dt, "dt", above=0.0, at_most=_MAX_STEP)
        return self._at_each(lambda points: self._compiled.moved(points, span), position)

    def export(self, path: str | PathLike[str]) -> None:
        """Writes the policy to a file that `leadthrough::load_policy` in C++ reads.

        Its velocities and steps are then the same to the bit, without Python. The file has the
        field, 8 bytes a cell.

        Args:
            path: the file; one that exists is replaced in one go.

        Raises:
            InvalidInput: if the file cannot be written.
        """
        npz.write_tables(path, "marching policy", self._tables())

    def _at_each(
        self, function: Callable[[Float64Array], tuple[int, Float64Array]], position: ArrayLike
    ) -> Float64Array:
        d = self.grid.dimensions
        points = check.array_of_rank(position, "position", shapes=((d,), ("n", d)))
        count, found = function(np.ascontiguousarray(points.reshape(-1, d)))
        if count < len(found):  # at this point there is no velocity, and here is why
            direction(self.arrival, self.grid, found[count : count + 1])
        return found.reshape(points.shape)

    @cached_property
    def _compiled(self) -> core.MarchingPolicy:
        grid, speeds, disc = self.grid, self.speeds, self.barrier
        return core.MarchingPolicy(
            self.arrival,
            grid.spacing,
            grid.origin,
            self.goal,
            speeds.positions,
            speeds.speeds,
            speeds.mean,
            self.slowing,
            None if disc is None else (disc.middle, disc.normal, disc.width, disc.thickness),
        )

    def _tables(self) -> dict[str, ArrayLike]:
        """The same by name, for a file."""
        grid, speeds, disc = self.grid, self.speeds, self.barrier
        barrier = {} if disc is None else vars(disc)
        return {
            "arrival": self.arrival,
            "shape": grid.shape,
            "spacing": grid.spacing,
            "origin": grid.origin,
            "goal": self.goal,
            "positions": speeds.positions,
            "speeds": speeds.speeds,
            "mean_speed": speeds.mean,
            "slowing": self.slowing,
            **{f"barrier_{name}": value for name, value in barrier.items()},
        }

    def around(self, obstacles: Sequence[Shape], *, position: ArrayLike | None = None) -> Policy:
        """The policy for the same goal among other obstacles, which may have moved."""
        shapes = check_shapes(obstacles)
        if position is None:
            return replace(self, arrival=self._map.repaired(shapes))
        point = check.array(position, "position", shape=(self.grid.dimensions,))
        if not self.grid.contains(point[None])[0]:
            raise InvalidInput(f"position: expected a point inside the grid, got {point}")
        if self.barrier is not None and self._is_at(self.barrier, point):
            point = point + _PAST_BARRIER * self.barrier.thickness * self.barrier.normal
        return replace(self, arrival=self._map.until(shapes, point))

    def _is_at(self, barrier: StartBarrier, point: Float64Array) -> bool:
        """Whether a point's cell, or one that its gradient needs, belongs to the barrier."""
        return bool(
            barrier.contains(point - np.outer([0.0, 1.0], self.grid.spacing * barrier.normal)).any()
        )


def policy_to(
    known: Sequence[Experience], goal: Float64Array, obstacles: Sequence[Shape], scales: Scales
) -> Policy:
    """The policy to a goal in the map of all demonstrations."""
    paths = [each.denoised for each in known]
    room = _PUSHED * float(np.ptp(np.concatenate(paths), axis=0).max())
    corners = np.concatenate([goal[None] - room, goal[None] + room, *paths])
    if scales.workspace is not None:
        corners = np.concatenate([goal[None], *paths])
    grid, scales = grid_over([corners], obstacles, scales)
    speed = speeds_along(paths, grid, scales)
    barrier = start_barrier(known, goal, grid, scales)
    if barrier is not None:
        goal = barrier.goal
        speed[barrier.cells(grid)] = 0.0
    repaired = _PolicyMap(grid, speed, goal, scales)
    arrival = repaired.arrival(obstacles)
    return Policy(grid, arrival, goal, DemonstratedSpeeds(known), scales.radius, barrier, repaired)


class _PolicyMap:
    """The map of a policy without obstacles, and its arrival times while obstacles move."""

    def __init__(self, grid: Grid, speed: Float64Array, goal: Float64Array, scales: Scales) -> None:
        self._grid, self._speed, self._goal, self._scales = grid, speed, goal, scales
        self._free: NDArray[np.float32] | None = None
        self._field: ArrivalField | None = None

    def arrival(self, obstacles: Sequence[Shape]) -> Times:
        """Arrival times of second order, marched anew."""
        speed = with_detours(self._speed, self._grid, obstacles, self._scales)
        self._check_goal(speed)
        source = self._grid.cells_of(self._goal[None])
        return arrival_times(speed, source, spacing=self._grid.spacing)

    def until(self, obstacles: Sequence[Shape], position: Float64Array) -> Times:
        """Arrival times of first order, marched no farther than to a position (d,)."""
        speed = self._around(obstacles)
        source, stop = self._grid.cells_of(np.stack([self._goal, position]))
        times = arrival_times(
            speed, source[None], spacing=self._grid.spacing, order=1, dtype=np.float32, stop=stop
        )
        if np.isinf(times[tuple(stop)]):
            raise NoPath(
                f"position: {position} lies in an obstacle, or obstacles separate it from the goal",
                reason="goal_enclosed",
            )
        return times

    def repaired(self, obstacles: Sequence[Shape]) -> Times:
        """Arrival times of first order, marched anew only where obstacles have moved."""
        speed = self._around(obstacles)
        if self._field is None:
            self._field = ArrivalField(speed, self._grid, self._goal, dtype=np.float32)
        else:
            self._field.update(speed)
        return self._field.times

    def _around(self, obstacles: Sequence[Shape]) -> NDArray[np.float32]:
        if self._free is None:
            self._free = self._speed.astype(np.float32)
        speed = with_detours(self._free, self._grid, obstacles, self._scales)
        self._check_goal(speed)
        return speed

    def _check_goal(self, speed: Times) -> None:
        if speed[tuple(self._grid.cells_of(self._goal[None])[0])] == 0.0:
            raise NoPath(f"goal: {self._goal} lies in an obstacle", reason="goal_in_wall")


@dataclass(frozen=True, eq=False)
class StartBarrier:
    """A disc across the start of a motion that returns there: the wave goes around the motion."""

    middle: Float64Array  # (d,)
    normal: Float64Array  # unit vector (d,) along the path
    width: float  # half of the disc's
    thickness: float  # half of it
    goal: Float64Array  # (d,) before the barrier, where the motion ends

    def contains(self, points: Float64Array) -> NDArray[np.bool_]:
        """Whether points (..., d) lie in it, (...)."""
        along, across = self._parts(points)
        return np.asarray((np.abs(along) <= self.thickness) & (across <= self.width))

    def cells(self, grid: Grid) -> tuple[NDArray[np.int64], ...]:
        """Indices of the cells whose centres lie in it."""
        reach = self.width + self.thickness
        corners = grid.coordinates(np.stack([self.middle - reach, self.middle + reach]))
        low = np.maximum(np.floor(corners[0]).astype(int), 0)
        high = np.minimum(np.ceil(corners[1]).astype(int) + 1, grid.shape)
        box = np.meshgrid(*map(np.arange, low, high), indexing="ij")
        cells = np.stack(box, axis=-1).reshape(-1, grid.dimensions)
        return tuple(cells[self.contains(grid.points_at(cells.astype(np.float64)))].T)

    def _parts(self, points: Float64Array) -> tuple[Float64Array, Float64Array]:
        away = points - self.middle
        along = away @ self.normal
        return along, np.linalg.norm(away - along[..., None] * self.normal, axis=-1)


def start_barrier(
    known: Sequence[Experience], goal: Float64Array, grid: Grid, scales: Scales
) -> StartBarrier | None:
    """The barrier before a goal (d,) at which all demonstrations start and end; None elsewhere."""
    for each in known:
        ends = each.denoised[[0, -1]]
        if np.linalg.norm(ends - goal, axis=1).max() > _RETURNS * each.length:
            return None
    mean = np.mean([by_arc_length(each.denoised, _SAMPLES) for each in known], axis=0)
    out, back = mean[_TANGENT] - mean[0], mean[-1] - mean[-1 - _TANGENT]
    normal = out / np.linalg.norm(out) + back / np.linalg.norm(back)
    if np.linalg.norm(normal) < _MIN_NORMAL:
        return None
    normal = normal / np.linalg.norm(normal)
    cell = float(grid.spacing.max())
    length = float(np.mean([each.length for each in known]))
    width = max(_RADII * scales.radius, _LENGTHS * scales.saturation * length)
    return StartBarrier(
        middle=goal - _TO_BARRIER * cell * normal,
        normal=normal,
        width=min(width, _EXTENT * float(np.ptp(mean, axis=0).max())),
        # Half a diagonal: no step between neighbouring cells leads through.
        thickness=0.5 * float(np.linalg.norm(grid.spacing)),
        goal=goal - _TO_GOAL * cell * normal,
    )


class DemonstratedSpeeds:
    """Speeds along demonstrations, by position."""

    def __init__(self, known: Sequence[Experience]) -> None:
        positions, speeds = zip(*(_along(each) for each in known), strict=True)
        self.mean = float(np.mean([each.length / each.duration for each in known]))
        self.positions = np.concatenate(positions)  # (n, d)
        self.speeds = np.maximum(np.concatenate(speeds), _MIN_SPEED * self.mean)  # (n,)


def _along(known: Experience) -> tuple[Float64Array, Float64Array]:
    """Positions (n, d) along a demonstration and the speeds (n,) there."""
    covered = arc_length(known.denoised)
    wanted = known.progress[::_STEP] * covered[-1]
    positions = lerp(wanted, covered, known.denoised)
    rate = curves.speed_of(known.progress)[::_STEP] * (curves.PROGRESS_SAMPLES - 1) / known.duration
    return positions, rate * covered[-1]
