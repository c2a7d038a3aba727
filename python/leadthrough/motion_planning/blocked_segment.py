"""Segments of a path of the tip without collision-free configurations of the arm."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.arm import Arm, Axis, HeldObject, IkOptions
from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.shapes import Scene

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
        """The tested samples in the segment."""
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
