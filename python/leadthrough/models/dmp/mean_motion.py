"""Means of demonstrations over normalised time: of whole motions, or of the periods of rhythms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from leadthrough import rotations
from leadthrough.check import FitError, Float64Array
from leadthrough.models.coordinates import Posture, demonstrated_posture, mean_orientations
from leadthrough.models.protocol import Demonstrations, motions_of, warn_of_misalignment
from leadthrough.motion import (
    Event,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    agreed_events,
    events_within,
    joints_with,
    lerp,
    moved_events,
    normalised_times,
)
from leadthrough.preprocess.align import positions_at

# A period whose last samples are missing, up to this fraction of it, counts as whole.
_SLACK = 0.02
_MIN_SAMPLES = 4  # of a period


@dataclass(frozen=True, eq=False)
class MeanMotion:
    """One motion that primitives are fitted to."""

    phases: Float64Array  # (n,) from 0 to 1
    positions: Float64Array  # (n, d)
    orientations: Float64Array | None  # (n, 4) w, x, y, z, or None
    duration: float  # s
    joint_names: tuple[str, ...] | None  # of joint motions, else None
    events: tuple[Event, ...] = ()  # at phases
    posture: Posture | None = None  # the arm's joints at phases, or None

    @property
    def size(self) -> float:
        """Diagonal of the box around the positions, in their unit."""
        return float(np.linalg.norm(np.ptp(self.positions, axis=0)))


def mean_motion(demonstrations: Demonstrations[Motion]) -> MeanMotion:
    """The mean of demonstrations over normalised time."""
    motions = motions_of(demonstrations)
    first = motions[0]
    names = first.joint_names if isinstance(first, JointTrajectory) else None
    happened = agreed_events(
        [moved_events(each.events, each.times[[0, -1]], (0.0, 1.0)) for each in motions]
    )
    phases = [normalised_times(motion.times) for motion in motions]
    posture = demonstrated_posture(motions, phases)
    if len(motions) == 1:
        q = first.orientations if isinstance(first, PoseTrajectory) else None
        return MeanMotion(phases[0], first.positions, q, first.duration, names, happened, posture)
    count = max(len(motion.times) for motion in motions)
    even = np.linspace(0.0, 1.0, count)
    positions = np.mean([positions_at(motion, even) for motion in motions], axis=0)
    duration = float(np.mean([motion.duration for motion in motions]))
    q = _mean_orientations(motions, even)
    warn_of_misalignment(motions)
    return MeanMotion(even, positions, q, duration, names, happened, posture)


def mean_cycle(demonstrations: Demonstrations[Motion], period: float | None) -> MeanMotion:
    """The mean over all whole periods in the demonstrations, closed: it ends where it began."""
    cycles = motions_of(demonstrations)
    if period is not None:
        cycles = [part for motion in cycles for part in _periods(motion, period)]
    mean = mean_motion(cycles)
    gap = mean.positions[-1] - mean.positions[0]
    positions = mean.positions - np.outer(mean.phases, gap)
    q = mean.orientations
    if q is not None:
        off = rotations.log(rotations.compose(q[:1], rotations.inverse(q[-1:])))
        q = rotations.compose(rotations.exp(np.outer(mean.phases, off[0])), q)
    return replace(mean, positions=positions, orientations=q)


def _mean_orientations(motions: Sequence[Motion], phases: Float64Array) -> Float64Array | None:
    layers = [
        rotations.interpolate(normalised_times(motion.times), motion.orientations, phases)
        for motion in motions
        if isinstance(motion, PoseTrajectory)
    ]
    return mean_orientations(layers) if layers else None


def _periods(motion: Motion, period: float) -> list[Motion]:
    """The whole periods of a motion, each from time 0 on."""
    count = int(motion.duration / period + _SLACK)
    if count == 0:
        raise FitError(
            f"demonstrations: expected at least one period of {period:.4g} s, "
            f"got {motion.duration:.4g} s"
        )
    samples = int(np.ceil(len(motion.times) * period / motion.duration))
    if samples < _MIN_SAMPLES:
        raise FitError(
            f"demonstrations: expected at least {_MIN_SAMPLES} samples in a period of "
            f"{period:.4g} s, got {samples}"
        )
    return [_part(motion, index * period, period, samples) for index in range(count)]


def _part(motion: Motion, begin: float, period: float, samples: int) -> Motion:
    own = np.linspace(0.0, period, samples)
    at = np.minimum(motion.times[0] + begin + own, motion.times[-1])
    positions = lerp(at, motion.times, motion.positions)
    happening = moved_events(events_within(motion.events, at[0], at[-1]), at, own)
    joints = joints_with(motion)
    if joints is not None:
        rows = lerp(at, motion.times, joints.positions)
        joints = JointTrajectory(own, rows, joint_names=joints.joint_names)
    if isinstance(motion, PoseTrajectory):
        q = rotations.interpolate(motion.times, motion.orientations, at)
        return PoseTrajectory(own, positions, q, happening, joints)
    if isinstance(motion, JointTrajectory):
        return JointTrajectory(own, positions, joint_names=motion.joint_names, events=happening)
    return Trajectory(own, positions, happening, joints)
