"""One round of a rhythmic motion, from demonstrations of one or more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough import events, rotations
from leadthrough.errors import FitError
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.dmp.mean_motion import MeanMotion, mean_motion
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory

# Rounds short of their last sample by this share of a period count as whole.
_SLACK = 0.02
_LEAST_SAMPLES = 4  # of a round


def mean_round(
    demonstrations: Demonstrations[Motion], kinds: tuple[type[Motion], ...], period: float | None
) -> MeanMotion:
    """The mean over all whole rounds in the demonstrations, closed: it ends where it began.

    period: s; None where each demonstration is one round. What is left over after the last whole
    round is dropped, and what a round's end lies off its beginning is spread evenly over it.
    Raises InvalidInput; FitError for demonstrations shorter than a period or that do not move.
    """
    rounds = motions_of(demonstrations, kinds=kinds)
    if period is not None:
        rounds = [part for motion in rounds for part in _rounds(motion, period)]
    shown = mean_motion(rounds, kinds)
    gap = shown.positions[-1] - shown.positions[0]
    positions = shown.positions - np.outer(shown.phases, gap)
    turned = shown.orientations
    if turned is not None:
        off = rotations.log(rotations.compose(turned[:1], rotations.inverse(turned[-1:])))
        turned = rotations.compose(rotations.exp(np.outer(shown.phases, off[0])), turned)
    return replace(shown, positions=positions, orientations=turned)


def _rounds(motion: Motion, period: float) -> list[Motion]:
    count = int(motion.duration / period + _SLACK)
    if count == 0:
        raise FitError(
            f"demonstrations: expected at least one period of {period:.4g} s, "
            f"got {motion.duration:.4g} s"
        )
    samples = int(np.ceil(len(motion.times) * period / motion.duration))
    if samples < _LEAST_SAMPLES:
        raise FitError(f"demonstrations: have {samples} samples in a period of {period:.4g} s")
    return [_part(motion, index * period, period, samples) for index in range(count)]


def _part(motion: Motion, begin: float, period: float, samples: int) -> Motion:
    own = np.linspace(0.0, period, samples)
    at = np.minimum(motion.times[0] + begin + own, motion.times[-1])
    positions = np.column_stack(
        [np.interp(at, motion.times, column) for column in motion.positions.T]
    )
    happening = events.moved(events.within(motion.events, at[0], at[-1]), at, own)
    if isinstance(motion, PoseTrajectory):
        turned = rotations.interpolate(motion.times, motion.orientations, at)
        return PoseTrajectory(own, positions, turned, happening)
    if isinstance(motion, JointTrajectory):
        return JointTrajectory(own, positions, joint_names=motion.joint_names, events=happening)
    return Trajectory(own, positions, happening)
