"""Where an arm can stand clear with its tip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.arm import Arm, IkOptions
from leadthrough.arm.inverse_kinematics import Axis
from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.shapes import Scene

# Configurations that inverse kinematics starts from: few at first, more where those fail.
_TRIES = (4, 28)
_AT_ENDS = (64, 448)  # without them the motion cannot be
_ITERATIONS = 60
# m between the places of a path that are looked at.
_SPACING = 0.02


@dataclass(frozen=True, eq=False)
class Room:
    """The room that obstacles leave to an arm."""

    arm: Arm  # the arm
    scene: Scene  # with the margins to keep
    free: Sequence[Axis]  # axes of the tip's poses left free

    def stands(
        self,
        positions: Float64Array,
        orientations: Float64Array | None,
        near: Float64Array,
        tries: tuple[int, ...] = _TRIES,
    ) -> NDArray[np.bool_]:
        """Whether the arm can stand clear, found by trying: a "no" may miss a way to stand."""
        found = np.zeros(len(positions), dtype=bool)
        rng = np.random.default_rng(0)
        lower, upper = (np.clip(ends, -np.pi, np.pi) for ends in self._limits())
        seeds = np.vstack([near[None], rng.uniform(lower, upper, (sum(tries) - 1, len(near)))])
        for some in np.split(seeds, np.cumsum(tries)[:-1]):
            open_ = np.flatnonzero(~found)
            if len(open_) == 0:
                break
            each = np.repeat(open_, len(some))
            batch = self.arm.inverse_kinematics_batch(
                positions[each],
                None if orientations is None else orientations[each],
                q0=np.tile(some, (len(open_), 1)),
                options=IkOptions(
                    free=self.free,
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

    def _limits(self) -> tuple[Float64Array, Float64Array]:
        return self.arm.limits.lower, self.arm.limits.upper


@dataclass(frozen=True, eq=False)
class Narrows:
    """A part of a path that leaves the arm no room."""

    places: NDArray[np.int64]
    first: int  # the first of the places that is in the part
    last: int  # the last one

    @property
    def samples(self) -> NDArray[np.int64]:
        """The samples of the path that are in it."""
        return self.places[self.first : self.last + 1]

    @property
    def end(self) -> str | None:
        """The end of the path that is in it, "start" or "goal", if one is."""
        if self.first == 0:
            return "start"
        return "goal" if self.last == len(self.places) - 1 else None

    def widened(self, count: int) -> Narrows:
        """With more places on either side, but without the path's ends."""
        first, last = max(1, self.first - count), min(len(self.places) - 2, self.last + count)
        return Narrows(self.places, first, last)


def narrows_at(
    room: Room, tip: Trajectory | PoseTrajectory, sample: int, near: Float64Array
) -> Narrows:
    """The part of a path around a sample where the arm cannot stand; at least that sample."""
    length = along(tip)
    places = np.searchsorted(length, np.arange(0.0, length[-1], _SPACING))
    places = np.unique(np.append(places, [sample, len(tip) - 1]))
    stands = room.stands(tip.positions[places], turned(tip, places), near)
    ends = places[[0, -1]]
    stands[[0, -1]] |= room.stands(tip.positions[ends], turned(tip, ends), near, _AT_ENDS)
    at = int(np.searchsorted(places, sample))
    # The search may have ended some samples before there is no room at all.
    if stands[at] and at + 1 < len(places) and not stands[at + 1]:
        at += 1
    first = last = at
    while first > 0 and not stands[at] and not stands[first - 1]:
        first -= 1
    while last + 1 < len(places) and not stands[at] and not stands[last + 1]:
        last += 1
    return Narrows(places, first, last)


def along(tip: Trajectory | PoseTrajectory) -> Float64Array:
    """The way from the start to each sample (n,), m."""
    steps = np.linalg.norm(np.diff(tip.positions, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def turned(tip: Trajectory | PoseTrajectory, samples: NDArray[np.int64]) -> Float64Array | None:
    """The orientations (k, 4) at samples (k,); None for points."""
    return tip.orientations[samples] if isinstance(tip, PoseTrajectory) else None
