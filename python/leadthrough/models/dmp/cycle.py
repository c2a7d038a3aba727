"""One period of a rhythmic motion, from demonstrations of one or more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough import events, rotations
from leadthrough.errors import FitError
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.dmp.mean_motion import MeanMotion, mean_motion
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory, joints_with

# A period whose last samples are missing, up to this fraction of it, counts as whole.
_SLACK = 0.02
_LEAST_SAMPLES = 4  # of a period


def mean_cycle(demonstrations: Demonstrations[Motion], period: float | None) -> MeanMotion:
    """The mean over all whole periods in the demonstrations, closed: it ends where it began."""
    cycles = motions_of(demonstrations)
    if period is not None:
        cycles = [part for motion in cycles for part in _periods(motion, period)]
    mean = mean_motion(cycles)
    gap = mean.positions[-1] - mean.positions[0]
    positions = mean.positions - np.outer(mean.phases, gap)
    turned = mean.orientations
    if turned is not None:
        off = rotations.log(rotations.compose(turned[:1], rotations.inverse(turned[-1:])))
        turned = rotations.compose(rotations.exp(np.outer(mean.phases, off[0])), turned)
    return replace(mean, positions=positions, orientations=turned)


def _periods(motion: Motion, period: float) -> list[Motion]:
    """The whole periods of a motion, each from time 0 on."""
    count = int(motion.duration / period + _SLACK)
    if count == 0:
        raise FitError(
            f"demonstrations: expected at least one period of {period:.4g} s, "
            f"got {motion.duration:.4g} s"
        )
    samples = int(np.ceil(len(motion.times) * period / motion.duration))
    if samples < _LEAST_SAMPLES:
        raise FitError(
            f"demonstrations: expected at least {_LEAST_SAMPLES} samples in a period of "
            f"{period:.4g} s, got {samples}"
        )
    return [_part(motion, index * period, period, samples) for index in range(count)]


def _part(motion: Motion, begin: float, period: float, samples: int) -> Motion:
    own = np.linspace(0.0, period, samples)
    at = np.minimum(motion.times[0] + begin + own, motion.times[-1])
    positions = np.column_stack(
        [np.interp(at, motion.times, column) for column in motion.positions.T]
    )
    happening = events.moved(events.within(motion.events, at[0], at[-1]), at, own)
    joints = joints_with(motion)
    if joints is not None:
        rows = [np.interp(at, motion.times, column) for column in joints.positions.T]
        joints = JointTrajectory(own, np.column_stack(rows), joint_names=joints.joint_names)
    if isinstance(motion, PoseTrajectory):
        turned = rotations.interpolate(motion.times, motion.orientations, at)
        return PoseTrajectory(own, positions, turned, happening, joints)
    if isinstance(motion, JointTrajectory):
        return JointTrajectory(own, positions, joint_names=motion.joint_names, events=happening)
    return Trajectory(own, positions, happening, joints)
