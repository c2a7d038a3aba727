"""Paths of the tip that a skill makes of a query, and detours around segments that are blocked.

A segment is blocked where the arm has no collision-free configurations.

In the map of a Fast Marching skill, cells without a collision-free configuration are closed. The
path of any other skill is moved aside, in small steps.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.arm import Arm, Axis, HeldObject, IkOptions
from leadthrough.arm.ik_failure import with_reason
from leadthrough.check import Float64Array, IkFailure, NoPath, ShortRepr
from leadthrough.models.protocol import Mapped, Skill
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Target, Trajectory
from leadthrough.shapes import PointCloud, Scene, Shape
from leadthrough.trajectories import minimum_jerk_time_scaling

# Start configurations of inverse kinematics: few at first, more where those fail.
_TRIES = (4, 28)
_AT_ENDS = (64, 448)  # without them the motion cannot be
_ITERATIONS = 60
_SIX = 6  # joints, with which an arm can have any position and orientation
# Distance between the samples of a path that are tested, m.
_SPACING = 0.02


@dataclass(frozen=True, eq=False)
class CollisionFreeIk:
    """Inverse kinematics of an arm, or of two that hold an object, in a scene: random restarts."""

    arm: Arm | HeldObject
    scene: Scene  # with the margins to keep
    free: Collection[Axis] | None  # axes of the tip's poses left free, as `Arm.follow` takes them

    @property
    def single(self) -> Arm:
        """The arm: an object in two hands is not taken through joint space."""
        assert isinstance(self.arm, Arm)
        return self.arm

    def exists(
        self,
        positions: Float64Array,
        orientations: Float64Array | None,
        near: Float64Array,
        tries: tuple[int, ...] = _TRIES,
    ) -> NDArray[np.bool_]:
        """Whether poses have a collision-free configuration; a "no" may miss one."""
        found = np.zeros(len(positions), dtype=bool)
        rng = np.random.default_rng(0)
        lower, upper = (np.clip(ends, -np.pi, np.pi) for ends in self._limits())
        starts = np.vstack([near[None], rng.uniform(lower, upper, (sum(tries) - 1, len(near)))])
        for some in np.split(starts, np.cumsum(tries)[:-1]):
            open_ = np.flatnonzero(~found)
            if len(open_) == 0:
                break
            each = np.repeat(open_, len(some))
            batch = self.arm.inverse_kinematics_batch(
                positions[each],
                None if orientations is None else orientations[each],
                q0=np.tile(some, (len(open_), 1)),
                options=IkOptions(
                    free=self._free(),
                    position_tolerance=1e-4,
                    orientation_tolerance=1e-3,
                    max_iterations=_ITERATIONS,
                    max_restarts=0,
                ),
            )
            reached = np.flatnonzero(batch.success)
            if len(reached) == 0:
                continue
            clear = self.arm.is_clear(batch.q[reached], self.scene.for_planning())
            found[each[reached[clear]]] = True
        return found

    def _free(self) -> tuple[Axis, ...]:
        """The axes free where the arm stands: of fewer than six joints, it turns as it has to."""
        if self.free is None and len(self.arm.joint_names) < _SIX:
            return ("rx", "ry", "rz")
        return tuple(self.free or ())

    def _limits(self) -> tuple[Float64Array, Float64Array]:
        return self.arm.limits.lower, self.arm.limits.upper


@dataclass(frozen=True, eq=False)
class BlockedSegment:
    """A part of a path without collision-free configurations of the arm."""

    tested: NDArray[np.int64]  # samples of the path, in order
    first: int  # index of the first tested sample in the segment
    last: int  # index of the last one

    @property
    def samples(self) -> NDArray[np.int64]:
        return self.tested[self.first : self.last + 1]

    @property
    def end(self) -> str | None:
        """The end of the path in the segment, "start" or "goal", if there is one."""
        if self.first == 0:
            return "start"
        return "goal" if self.last == len(self.tested) - 1 else None

    def widened(self, count: int) -> BlockedSegment:
        """With more tested samples on either side, but without the path's ends."""
        first, last = max(1, self.first - count), min(len(self.tested) - 2, self.last + count)
        return BlockedSegment(self.tested, first, last)


def blocked_segment_at(
    ik: CollisionFreeIk, tip: Trajectory | PoseTrajectory, sample: int, near: Float64Array
) -> BlockedSegment:
    """The blocked segment around a sample; at least that sample."""
    length = path_lengths(tip)
    tested = np.searchsorted(length, np.arange(0.0, length[-1], _SPACING))
    tested = np.unique(np.append(tested, [sample, len(tip) - 1]))
    free = ik.exists(tip.positions[tested], orientations_at(tip, tested), near)
    ends = tested[[0, -1]]
    free[[0, -1]] |= ik.exists(tip.positions[ends], orientations_at(tip, ends), near, _AT_ENDS)
    at = int(np.searchsorted(tested, sample))
    # The search may have ended some samples before the segment.
    if free[at] and at + 1 < len(tested) and not free[at + 1]:
        at += 1
    first = last = at
    while first > 0 and not free[at] and not free[first - 1]:
        first -= 1
    while last + 1 < len(tested) and not free[at] and not free[last + 1]:
        last += 1
    return BlockedSegment(tested, first, last)


def path_lengths(tip: Trajectory | PoseTrajectory) -> Float64Array:
    """Path length from the start to each sample (n,), m."""
    steps = np.linalg.norm(np.diff(tip.positions, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def orientations_at(
    tip: Trajectory | PoseTrajectory, samples: NDArray[np.int64]
) -> Float64Array | None:
    """The orientations (k, 4) at samples (k,); None for points."""
    return tip.orientations[samples] if isinstance(tip, PoseTrajectory) else None


TipMotion = Trajectory | PoseTrajectory
# Samples of the path beyond a blocked segment at which the arm is past it.
_PAST = 2
# Distance around a blocked segment that is searched, m, and its growth in each round.
_REACH, _GROWTH = 0.08, 1.4
# Cells from the segment to the edge of the searched region.
_CELLS = 3
# Radius of a closed ball, in cells: those of neighbours overlap.
_COVER = 0.75
# Distances that a segment is moved by, m, in the order of trial; from the fourth on it is widened.
_OFFSETS = (0.02, 0.035, 0.05, 0.08, 0.12, 0.16, 0.22, 0.3)
_NOT_WIDENED = 2
# Length of the transition to and from the detour, over the offset.
_RAMP = 3.0
# Samples of the segment that are tested in each direction.
_TESTED = 9
# To all faces, edges and corners of a cube.
_DIRECTIONS = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)], dtype=float)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1)[:, None]


@dataclass(frozen=True, eq=False)
class Query(ShortRepr):
    """A query to a skill, as `skill.generate` takes it.

    Attributes:
        start: of the motion; None for the demonstrated start.
        goal: its end, likewise.
        duration: s, > 0; None for the skill's own.
        dt: s, > 0, upper bound of the sampling step.

    Raises:
        InvalidInput: if the duration or dt is not a positive number.
    """

    start: Target | None = None
    goal: Target | None = None
    duration: float | None = None
    dt: float = 0.01

    def __post_init__(self) -> None:
        CheckedQuery(self.start, self.goal, self.duration, self.dt)
        for name in ("start", "goal"):
            if (target := getattr(self, name)) is not None:
                object.__setattr__(self, name, _frozen_target(target, name))

    def arguments(self) -> dict[str, Any]:
        """The arguments of `skill.generate` that are given, by name."""
        given = {"start": self.start, "goal": self.goal, "duration": self.duration, "dt": self.dt}
        return {name: value for name, value in given.items() if value is not None}


class TipPaths:
    def __init__(self, skill: Skill[Motion], query: Query, ik: CollisionFreeIk) -> None:
        self._skill = skill
        self._query = query
        self._ik = ik
        self._closed: tuple[Shape, ...] = ()
        self._changes = 0
        self._beside: Iterator[TipMotion] = iter(())
        self._past = -1  # the sample at which the arm is past the part

    def first(self) -> TipMotion:
        return self._generated(())

    def another(self, path: TipMotion, failure: IkFailure) -> TipMotion:
        """Another path, for one that the arm could not follow."""
        found: TipMotion | None
        if isinstance(self._skill, Mapped):
            found = self._closing(path, failure)
        else:
            found = self._aside(path, failure)
        if found is None:
            raise with_reason(failure, "no other path of the tip was found")
        return found

    def _closing(self, path: TipMotion, failure: IkFailure) -> TipMotion | None:
        segment = self._segment(path, failure)
        self._closed += closed_cells(self._ik, path, segment, failure.q, self._changes)
        self._changes += 1
        try:
            return self._generated(self._closed)
        except NoPath:
            return None

    def _aside(self, path: TipMotion, failure: IkFailure) -> TipMotion | None:
        if failure.index > self._past:
            segment = self._segment(path, failure)
            self._beside = detours(self._ik, path, segment, failure.q)
            self._past = int(segment.widened(_PAST).samples[-1])
        return next(self._beside, None)

    def _segment(self, path: TipMotion, failure: IkFailure) -> BlockedSegment:
        segment = blocked_segment_at(self._ik, path, failure.index, failure.q)
        if segment.end:
            raise with_reason(
                failure, f"no collision-free configuration found at the {segment.end}"
            )
        return segment

    def _generated(self, closed: tuple[Shape, ...]) -> TipMotion:
        query = self._query.arguments()
        shapes = self._ik.scene.shapes + closed
        if shapes and "obstacles" in self._skill.supports:
            query["obstacles"] = shapes
        motion = self._skill.generate(**query)
        if isinstance(motion, JointTrajectory):
            return self._ik.arm.poses(motion)
        return motion


def closed_cells(
    ik: CollisionFreeIk,
    tip: TipMotion,
    segment: BlockedSegment,
    near: Float64Array,
    changes: int,
) -> tuple[PointCloud, ...]:
    """Balls that cover the cells around a segment without collision-free configurations."""
    reach = _REACH * _GROWTH**changes
    cell = reach / _CELLS
    middles = tip.positions[segment.samples]
    cells, owners = _cells_around(middles, cell)
    rows = segment.samples[owners]
    free = ik.exists(cells, orientations_at(tip, rows), near)
    radius = _COVER * cell
    ends = tip.positions[[0, -1]]
    off_ends = np.linalg.norm(cells[:, None] - ends, axis=2).min(axis=1) > radius + cell
    closed = cells[~free & off_ends]
    if len(closed) == 0:
        # All cells have configurations, but none is connected: the segment itself is closed.
        apart = np.linalg.norm(middles[:, None] - ends, axis=2).min(axis=1) > radius + cell
        closed = middles[apart]
    return (PointCloud(closed, radius),) if len(closed) else ()


def _cells_around(middles: Float64Array, cell: float) -> tuple[Float64Array, NDArray[np.int64]]:
    """Cells of a grid within reach of the points, (m, 3), and the nearest point to each, (m,)."""
    reach = _CELLS * cell
    low = np.floor((middles.min(axis=0) - reach) / cell).astype(int)
    high = np.ceil((middles.max(axis=0) + reach) / cell).astype(int)
    axes = [np.arange(a, b + 1) for a, b in zip(low, high, strict=True)]
    cells = cell * np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    away = np.linalg.norm(cells[:, None] - middles, axis=2)
    within = away.min(axis=1) <= reach
    return cells[within], away[within].argmin(axis=1)


def detours(
    ik: CollisionFreeIk,
    tip: TipMotion,
    segment: BlockedSegment,
    near: Float64Array,
) -> Iterator[TipMotion]:
    """The path with the blocked segment moved aside, in small steps first."""
    length = path_lengths(tip)
    if length[segment.samples[0]] == 0.0 or length[segment.samples[-1]] == length[-1]:
        return
    for i, offset in enumerate(_OFFSETS):
        part = segment.widened(max(0, i - _NOT_WIDENED))
        directions = _open_directions(ik, tip, part, near, offset)
        if len(directions):
            opposite = directions[np.argmin(directions @ directions[0])]
            for direction in np.unique([directions[0], opposite], axis=0):
                aside = np.outer(_offset_fraction(tip, part, offset), offset * direction)
                yield replace(tip, positions=tip.positions + aside)


def _open_directions(
    ik: CollisionFreeIk,
    tip: TipMotion,
    part: BlockedSegment,
    near: Float64Array,
    offset: float,
) -> Float64Array:
    """The directions (k, 3) with collision-free configurations along the whole segment."""
    open_ = _DIRECTIONS
    for place in _middle_first(part.samples):
        asked = tip.positions[place] + offset * open_
        rows = np.full(len(open_), place)
        open_ = open_[ik.exists(asked, orientations_at(tip, rows), near)]
        if len(open_) == 0:
            break
    return open_


def _middle_first(samples: NDArray[np.int64]) -> NDArray[np.int64]:
    """A few evenly spaced samples; the middle first, where most directions fail."""
    count = min(_TESTED, len(samples))
    few = samples[np.linspace(0, len(samples) - 1, count).round().astype(int)]
    order = np.argsort(np.abs(np.arange(count) - 0.5 * (count - 1)), kind="stable")
    return np.asarray(few[order])


def _offset_fraction(tip: TipMotion, part: BlockedSegment, offset: float) -> Float64Array:
    """Fraction of the offset that each sample is moved by (n,), 0 to 1."""
    length = path_lengths(tip)
    first, last = length[part.samples[[0, -1]]]
    before = min(_RAMP * offset, first)
    after = min(_RAMP * offset, length[-1] - last)
    rise = minimum_jerk_time_scaling(np.clip((length - first + before) / before, 0.0, 1.0))
    fall = minimum_jerk_time_scaling(np.clip((last + after - length) / after, 0.0, 1.0))
    return np.asarray(rise * fall)


def _frozen_target(value: Target, name: str) -> Target:
    """A read-only copy of a target of finite numbers, an orientation of unit length."""
    if isinstance(value, tuple | list) and len(value) == 2 and check.rank(value[0]) > 0:
        position = check.frozen(value[0], name, shape=("d",))
        return position, check.unit_quaternions(value[1], name, shape=(4,))
    return check.frozen(value, name, shape=("d",))
