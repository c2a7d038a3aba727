"""Demonstrations as Fast Marching Learning keeps them, and their orientations along a path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from leadthrough import check, rotations
from leadthrough.check import FitError, Float64Array, ShortRepr
from leadthrough.models.coordinates import (
    Posture,
    agreed,
    demonstrated_posture,
    groups_of,
    mean_orientations,
)
from leadthrough.models.curves import PROGRESS_SAMPLES, progress_of, weighted_median
from leadthrough.models.protocol import Demonstrations, Outliers, motions_of
from leadthrough.motion import (
    Event,
    MotionT,
    PoseTrajectory,
    Trajectory,
    agreed_events,
    events_of_plain,
    kept,
    moved_events,
)
from leadthrough.noise import is_random_walk, without_noise
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.trajectories import minimum_jerk_time_scaling

# A demonstration is reversed where that brings its ends nearer to start and goal, in sum, by half
# and by a fraction of its length: those that return to their start keep their direction.
_CLEARLY, _AT_LEAST = 0.5, 0.1
# Found on human handwriting: between isochrony (0) and constant speed (1).
_DURATION_EXPONENT = 0.25
_NODES = 101  # of the mean orientation along the path
# Paths nearer to each other than this fraction of their length are followed together.
_SAME_BRANCH = 0.1


@dataclass(frozen=True, eq=False)
class Experience(ShortRepr):
    """A path that was demonstrated, or learned since, and how it was run through."""

    path: Float64Array  # (n, d) in the demonstrations' unit, as recorded
    duration: float  # s
    progress: Float64Array  # (1001,) fraction of the path covered, at evenly spaced times
    orientations: Float64Array | None = None  # (n, 4) w, x, y, z along the path, or None
    events: tuple[Event, ...] = ()  # at fractions of the path, 0 to 1
    posture: Posture | None = None  # the arm's joints at fractions of the path, or None

    @cached_property
    def denoised(self) -> Float64Array:
        """The path (n, d) without white noise; a smooth one is the path itself."""
        return without_noise(self.path)

    @cached_property
    def is_random_walk(self) -> bool:
        """Whether it is a random walk, which shows no path at all."""
        return is_random_walk(self.path)

    @cached_property
    def length(self) -> float:
        """Arc length of the denoised path, in its unit."""
        return float(arc_length(self.denoised)[-1])

    def towards(self, start: Float64Array, goal: Float64Array) -> Experience:
        """Itself, or reversed where that brings its ends clearly nearer to start and goal, (d,)."""
        gaps = [
            np.linalg.norm(first - start) + np.linalg.norm(last - goal)
            for first, last in ((self.path[0], self.path[-1]), (self.path[-1], self.path[0]))
        ]
        clearly = min(_CLEARLY * gaps[0], gaps[0] - _AT_LEAST * self.length)
        return self._reversed if gaps[1] < clearly else self

    def arrays(self) -> dict[str, Float64Array]:
        """Its arrays by name, for a file."""
        parts = {
            "path": self.path,
            "duration": np.array(self.duration),
            "progress": self.progress,
        }
        if self.orientations is not None:
            parts["orientations"] = self.orientations
        if self.posture is not None:
            parts["posture"] = self.posture.rows
        return parts

    @staticmethod
    def from_arrays(
        arrays: Mapping[str, Any],
        index: int,
        *,
        happening: Sequence[Any],
        joint_names: Sequence[str] | None = None,
    ) -> Experience:
        """The one of which a file has the `arrays` under <name>_<index>."""
        path = check.frozen(arrays[f"path_{index}"], "path", shape=("n", "d"))
        if len(path) < 2:
            raise check.refused("path", "at least two points", len(path))
        orientations = arrays.get(f"orientations_{index}")
        joints = None
        if joint_names is not None:
            stood = {"posture": arrays[f"posture_{index}"]}
            joints = Posture.from_archive({"posture": joint_names}, stood)
        return Experience(
            path,
            check.number(arrays[f"duration_{index}"], "duration", above=0.0),
            check.frozen(arrays[f"progress_{index}"], "progress", shape=(PROGRESS_SAMPLES,)),
            orientations
            if orientations is None
            else check.quaternions(orientations, "path", shape=(len(path), 4)),
            events_of_plain(happening),
            joints,
        )

    @cached_property
    def _reversed(self) -> Experience:
        orientations = None if self.orientations is None else self.orientations[::-1].copy()
        happened = tuple(Event(1.0 - each.time, each.name) for each in reversed(self.events))
        progress = 1.0 - self.progress[::-1]
        joints = None if self.posture is None else self.posture.reversed()
        return Experience(
            self.path[::-1].copy(), self.duration, progress, orientations, happened, joints
        )


def experience_of(
    demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "keep"
) -> tuple[Experience, ...]:
    """Experience of demonstrations: all of points in two or three dimensions, or all of poses."""
    kinds = (Trajectory, PoseTrajectory)
    motions: list[Any] = motions_of(demonstrations, kinds=kinds, at_least=0, outliers=outliers)
    for i, motion in enumerate(motions):
        width = motion.positions.shape[1]
        if width not in (2, 3):
            raise check.refused(f"demonstrations[{i}]", "points in two or three dimensions", width)
        if arc_length(motion.positions)[-1] == 0.0:
            raise FitError(
                f"demonstrations[{i}]: turns but does not move, and a path needs positions that "
                "differ; use DMP, ProMP or GMR"
            )
    return tuple(_experience(motion) for motion in motions)


@kept
def _experience(motion: Trajectory | PoseTrajectory) -> Experience:
    smooth = without_noise(motion.positions)
    covered = arc_length(smooth)
    return Experience(
        motion.positions,
        motion.duration,
        progress_of(motion.times, smooth),
        motion.orientations if isinstance(motion, PoseTrajectory) else None,
        moved_events(motion.events, motion.times, covered / covered[-1]),
        demonstrated_posture([motion], [covered / covered[-1]]),
    )


def nominal_duration(used: Sequence[Experience], weights: Float64Array, length: float) -> float:
    """The weighted median of the demonstrations' durations, s, each adapted to a path's length."""
    # The path of a reach that stands still has no length.
    ratios = [length / each.length or 1.0 for each in used]
    durations = [each.duration for each in used]
    adapted = np.array(durations) * [ratio**_DURATION_EXPONENT for ratio in ratios]
    return weighted_median(adapted, weights)


def experience_like(
    known: Sequence[Experience],
    path: Float64Array,
    orientations: Float64Array | None,
    *,
    duration: float | None,
) -> Experience:
    """A path (n, d) as experience, with the timing, events and joints of known ones."""
    progress = np.mean([each.progress for each in known], axis=0)
    length = float(arc_length(path)[-1])
    own = duration or nominal_duration(known, np.ones(len(known)), length)
    happened = agreed_events([each.events for each in known])
    joints = agreed([each.posture for each in known])
    return Experience(path, own, progress, orientations, happened, joints)


def refuse_opposed(known: Sequence[Experience]) -> None:
    """Checks that demonstrations of the same path have a mean orientation along it."""
    directed = [each.towards(known[0].path[0], known[0].path[-1]) for each in known]
    if any(each.orientations is None for each in directed):
        return
    phases = np.linspace(0.0, 1.0, _NODES)
    layers = [_at(each, phases) for each in directed]
    try:
        mean_orientations(layers)
    except FitError:
        near, far, *_ = groups_of(layers)
        lengths = [each.length for each in directed]
        for i, j in ((i, j) for i in near for j in far):
            if _gap(directed[i].path, directed[j].path) < _SAME_BRANCH * max(
                lengths[i], lengths[j]
            ):
                raise


def orientations_along(
    used: Sequence[Experience],
    weights: Float64Array,
    *,
    path: Float64Array,
    start: Float64Array | None = None,
    goal: Float64Array | None = None,
    fractions: Float64Array | None = None,
) -> Float64Array:
    """Orientations along a path that follows demonstrations, by default at its own points."""
    if fractions is None:
        covered = arc_length(path)
        fractions = covered / covered[-1]
    phases = np.linspace(0.0, 1.0, _NODES)
    chosen = [i for i, weight in enumerate(weights) if weight > 0.0]
    nodes = _agreed([used[i] for i in chosen], weights[chosen], path)
    mean = rotations.squad(phases, nodes, fractions)
    offsets = [
        np.zeros((1, 3))
        if wanted is None
        else rotations.log(rotations.compose(wanted[None], rotations.inverse(node[None])))
        for wanted, node in ((start, nodes[0]), (goal, nodes[-1]))
    ]
    blend = minimum_jerk_time_scaling(fractions)[:, None]
    turns = rotations.exp((1.0 - blend) * offsets[0] + blend * offsets[1])
    return rotations.align_signs(rotations.compose(turns, mean))


def _agreed(used: Sequence[Experience], weights: Float64Array, path: Float64Array) -> Float64Array:
    """Mean orientations (n, 4) of the demonstrations, or of the group nearest to a path."""
    phases = np.linspace(0.0, 1.0, _NODES)
    layers = [_at(each, phases) for each in used]
    try:
        return mean_orientations(layers, weights=weights)
    except FitError:
        groups = groups_of(layers)[:2]
        nearest = int(np.argmin([_gap(each.path, path) for each in used]))
        chosen = groups[0] if nearest in groups[0] else groups[1]
        return _agreed([used[i] for i in chosen], weights[chosen], path)


def _gap(one: Float64Array, other: Float64Array) -> float:
    """Root mean square distance of two paths at the same fractions of their lengths."""
    gaps = by_arc_length(one, _NODES) - by_arc_length(other, _NODES)
    return float(np.sqrt((gaps**2).sum(axis=1).mean()))


def _at(known: Experience, phases: Float64Array) -> Float64Array:
    """Orientations at fractions of the demonstration's own path; where it rests, the last one."""
    assert known.orientations is not None
    covered = arc_length(known.denoised)
    moving = np.concatenate([np.diff(covered) > 0.0, [True]])
    fraction = covered[moving] / covered[-1]
    fraction[0] = 0.0
    return rotations.interpolate(fraction, known.orientations[moving], phases)
