"""What a path-planning model keeps of a demonstration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import check, events
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput
from leadthrough.events import Event
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.phase import SAMPLES, progress_of
from leadthrough.motion import MotionT, PoseTrajectory, Trajectory
from leadthrough.preprocess.resample import arc_length


@dataclass(frozen=True, eq=False)
class Shown:
    """A demonstrated, or auto-learned, path.

    path: (n, d). duration: s. progress: (1001,) share of the path at even normalised times.
    orientations: (n, 4) w, x, y, z along the path, or None. events: at shares of the path.
    """

    path: Float64Array
    duration: float
    progress: Float64Array
    orientations: Float64Array | None = None
    events: tuple[Event, ...] = ()

    @property
    def length(self) -> float:
        """Arc length, in the path's unit."""
        return float(arc_length(self.path)[-1])

    def facing(self, start: Float64Array, goal: Float64Array) -> Shown:
        """Itself, or reversed where that brings its ends nearer to start and goal, (d,) each."""
        gaps = [
            np.linalg.norm(first - start) + np.linalg.norm(last - goal)
            for first, last in ((self.path[0], self.path[-1]), (self.path[-1], self.path[0]))
        ]
        if gaps[0] <= gaps[1]:
            return self
        turned = None if self.orientations is None else self.orientations[::-1].copy()
        happened = tuple(Event(1.0 - each.time, each.name) for each in reversed(self.events))
        progress = 1.0 - self.progress[::-1]
        return Shown(self.path[::-1].copy(), self.duration, progress, turned, happened)

    def arrays(self) -> dict[str, Float64Array]:
        """Its parts by name, for a file."""
        parts = {
            "path": self.path,
            "duration": np.array(self.duration),
            "progress": self.progress,
        }
        if self.orientations is not None:
            parts["orientations"] = self.orientations
        return parts

    @staticmethod
    def from_arrays(arrays: Mapping[str, Any], index: int) -> Shown:
        """The one whose `arrays` stand under <name>_<index>. Raises KeyError, InvalidInput."""
        path = check.frozen(arrays[f"path_{index}"], "path", shape=("n", "d"))
        turned = arrays.get(f"orientations_{index}")
        return Shown(
            path,
            check.number(arrays[f"duration_{index}"], "duration", above=0.0),
            check.frozen(arrays[f"progress_{index}"], "progress", shape=(SAMPLES,)),
            None if turned is None else check.quaternions(turned, "path", shape=(len(path), 4)),
        )


def keep(demonstrations: Demonstrations[MotionT]) -> tuple[Shown, ...]:
    """What to keep of demonstrations: all points in two or three dimensions, or all poses.

    Raises:
        InvalidInput: for other motions.
        FitError: for one of a single sample, or whose position does not move.
    """
    motions: list[Any] = motions_of(demonstrations, kinds=(Trajectory, PoseTrajectory), at_least=0)
    for i, motion in enumerate(motions):
        width = motion.positions.shape[1]
        if width not in (2, 3):
            raise InvalidInput(
                f"demonstrations[{i}]: expected points in two or three dimensions, got {width}"
            )
        if arc_length(motion.positions)[-1] == 0.0:
            raise FitError(f"demonstrations[{i}]: turns but does not move; a path needs positions")
    return tuple(_kept(motion) for motion in motions)


def _kept(motion: Trajectory | PoseTrajectory) -> Shown:
    covered = arc_length(motion.positions)
    return Shown(
        motion.positions,
        motion.duration,
        progress_of(motion.times, motion.positions),
        motion.orientations if isinstance(motion, PoseTrajectory) else None,
        events.moved(motion.events, motion.times, covered / covered[-1]),
    )
