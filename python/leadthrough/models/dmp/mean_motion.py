"""One motion from several demonstrations: their mean over normalised time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough import events, rotations
from leadthrough.check import Float64Array
from leadthrough.events import Event
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.mean_turning import mean_orientations
from leadthrough.models.out_of_step import warn_of_others_timing
from leadthrough.models.posture import Posture, shown_posture
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, normalised_times


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


def mean_motion(
    demonstrations: Demonstrations[Motion],
) -> MeanMotion:
    """The mean of demonstrations over normalised time."""
    motions = motions_of(demonstrations)
    first = motions[0]
    names = first.joint_names if isinstance(first, JointTrajectory) else None
    happened = events.agreed(
        [events.moved(each.events, each.times[[0, -1]], (0.0, 1.0)) for each in motions]
    )
    phases = [normalised_times(motion.times) for motion in motions]
    posture = shown_posture(motions, phases)
    if len(motions) == 1:
        turned = first.orientations if isinstance(first, PoseTrajectory) else None
        return MeanMotion(
            phases[0], first.positions, turned, first.duration, names, happened, posture
        )
    count = max(len(motion.times) for motion in motions)
    even = np.linspace(0.0, 1.0, count)
    positions = np.mean([_positions_at(motion, even) for motion in motions], axis=0)
    duration = float(np.mean([motion.duration for motion in motions]))
    turned = _mean_turn(motions, even)
    warn_of_others_timing(motions)
    return MeanMotion(even, positions, turned, duration, names, happened, posture)


def _positions_at(motion: Motion, phases: Float64Array) -> Float64Array:
    own = normalised_times(motion.times)
    return np.column_stack([np.interp(phases, own, column) for column in motion.positions.T])


def _mean_turn(motions: Sequence[Motion], phases: Float64Array) -> Float64Array | None:
    layers = [
        rotations.interpolate(normalised_times(motion.times), motion.orientations, phases)
        for motion in motions
        if isinstance(motion, PoseTrajectory)
    ]
    return mean_orientations(layers) if layers else None
