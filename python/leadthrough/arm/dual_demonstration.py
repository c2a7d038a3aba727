"""Demonstrations of two arms: the object that both hold, their relative motion, and both together.

A movement primitive of both tips is learned over their middle and their difference: columns of the
two tips that move alike are correlated, and the covariance of few demonstrations is shrunk towards
columns that are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough import check, rotations
from leadthrough.arm.rigid_transforms import Pose, Transforms, checked_grasps
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory, Trajectory

_HALF = 0.5 * np.eye(3)
_LEFT, _RIGHT = np.hstack([np.eye(3), -_HALF]), np.hstack([np.eye(3), _HALF])


@dataclass(frozen=True, eq=False)
class DualDemonstration(ShortRepr):
    """Motions of the left and the right tip on one clock, in one frame.

    Attributes:
        left: poses of the left tip.
        right: poses of the right tip. Of a motion with other times those of the left one that both
            cover count, and the right one is interpolated.
        joints: of both arms at the same times, or None.
        name: for messages and files.
    """

    left: PoseTrajectory
    right: PoseTrajectory
    joints: JointTrajectory | None = None
    name: str = ""

    def __post_init__(self) -> None:
        for side in ("left", "right"):
            check.instance(getattr(self, side), side, PoseTrajectory)
        left, right = self.left, self.right
        if not np.array_equal(left.times, right.times):
            covered = (left.times >= right.times[0]) & (left.times <= right.times[-1])
            if not covered.any():
                raise check.refused("right", "times that the left motion covers", repr(right))
            first, count = int(np.argmax(covered)), int(np.count_nonzero(covered))
            left = left[first : first + count]
            right = PoseTrajectory(left.times, *right.at(left.times), right.events)
            object.__setattr__(self, "left", left)
            object.__setattr__(self, "right", right)
        if self.joints is not None and not np.array_equal(self.joints.times, left.times):
            raise check.refused("joints", "the times of the tips", repr(self.joints))

    def object(self, grasps: tuple[Pose, Pose]) -> Demonstration[PoseTrajectory]:
        """The motion of an object that both hold, with the arms' joints.

        It is in the middle between the poses that either tip has it at.

        Args:
            grasps: poses of the left and of the right tip in the object's frame.
        """
        held = checked_grasps(grasps, Transforms.of)
        by_left, by_right = (
            _transforms(motion) @ grasp.inverse()
            for motion, grasp in zip((self.left, self.right), held, strict=True)
        )
        half = 0.5 * rotations.log((by_left.inverse() @ by_right).orientations)
        motion = PoseTrajectory(
            self.left.times,
            0.5 * (by_left.positions + by_right.positions),
            rotations.compose(by_left.orientations, rotations.exp(half)),
            self.left.events,
        )
        return Demonstration(motion, self.name, self.joints)

    @property
    def grasps(self) -> tuple[Pose, Pose]:
        """Grasps of an object whose frame is that of the left tip, for `object` and `follow`."""
        relative = self.relative
        mean = relative.positions.mean(axis=0), rotations.mean(relative.orientations)
        return Transforms.identity().single(), mean

    @property
    def relative(self) -> PoseTrajectory:
        """Poses of the right tip in the frame of the left one."""
        found = _transforms(self.left).inverse() @ _transforms(self.right)
        return PoseTrajectory(self.left.times, found.positions, found.orientations)

    @property
    def middle_and_difference(self) -> Trajectory:
        """Positions (n, 6) in m: the middle of both tips, then the right less the left one.

        A ProMP of these keeps what the arms do alike. `left_tip` and `right_tip` are the tasks for
        `condition_task`, and `tips_of` takes a motion apart.
        """
        left, right = self.left.positions, self.right.positions
        return Trajectory(self.left.times, np.hstack([0.5 * (left + right), right - left]))


def left_tip(both: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Position (3,) of the left tip in the columns (6,) of `middle_and_difference`; Jacobian."""
    return _LEFT @ both, _LEFT


def right_tip(both: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Position (3,) of the right tip in the columns (6,) of `middle_and_difference`; Jacobian."""
    return _RIGHT @ both, _RIGHT


def tips_of(motion: Trajectory) -> tuple[Trajectory, Trajectory]:
    """Motions of the left and the right tip, of one of `middle_and_difference`."""
    if not isinstance(motion, Trajectory) or motion.positions.shape[1] != _LEFT.shape[1]:
        raise check.refused("motion", "a Trajectory in 6-D", repr(motion))
    left, right = (
        Trajectory(motion.times, motion.positions @ matrix.T, motion.events)
        for matrix in (_LEFT, _RIGHT)
    )
    return left, right


def _transforms(motion: PoseTrajectory) -> Transforms:
    return Transforms(motion.positions, motion.orientations)
