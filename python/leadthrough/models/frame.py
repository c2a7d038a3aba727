"""Frames of reference that move with a task."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import JointTrajectory, Motion, MotionT, PoseTrajectory

# Largest entry of axes.T @ axes - identity that passes for rounding.
_ORTHONORMAL = 1e-6


@dataclass(frozen=True, eq=False)
class Frame(ShortRepr):
    """A frame of reference in the task: at a start, a goal or an object.

    Attributes:
        origin: origin (d,) in the base frame, m; for joints a configuration, rad.
        axes: orthonormal axes (d, d) as columns, by default those of the base frame. For poses
            (3, 3) and right-handed.
    """

    origin: Float64Array
    axes: Float64Array

    def __init__(self, origin: ArrayLike, axes: ArrayLike | None = None) -> None:
        own_origin = check.frozen(origin, "origin", shape=("d",))
        size = len(own_origin)
        if size == 0:
            raise check.refused("origin", "at least one number", "none")
        given = np.eye(size) if axes is None else axes
        own_axes = check.frozen(given, "axes", shape=(size, size))
        off = float(np.abs(own_axes.T @ own_axes - np.eye(size)).max())
        if off > _ORTHONORMAL:
            raise check.refused("axes", "orthonormal columns", f"axes.T @ axes off by {off:.3g}")
        vars(self).update(origin=own_origin, axes=own_axes)

    @staticmethod
    def of_pose(position: ArrayLike, orientation: ArrayLike) -> Frame:
        """The frame of a tool.

        Args:
            position: position (3,) of the tool in the base frame, m.
            orientation: orientation (4,) of the tool, w, x, y, z.
        """
        given = check.array(orientation, "orientation", shape=(4,))
        return Frame(position, rotations.to_matrix(given[None])[0])

    @staticmethod
    def of_sample(motion: Motion, row: int) -> Frame:
        """The frame at a sample of a motion; of poses with the tool's axes there.

        Args:
            motion: a motion in the base frame.
            row: index of the sample.
        """
        if isinstance(motion, PoseTrajectory):
            return Frame.of_pose(motion.positions[row], motion.orientations[row])
        return Frame(motion.positions[row])

    def local(self, motion: Motion) -> Motion:
        """A motion seen from this frame, without events and derivatives.

        Args:
            motion: the motion in the base frame.
        """
        positions = np.asarray((motion.positions - self.origin) @ self.axes)
        if not isinstance(motion, PoseTrajectory):
            return type(motion)(motion.times, positions)
        back = rotations.inverse(self.orientations(len(motion.times)))
        orientations = rotations.compose(back, motion.orientations)
        return PoseTrajectory(motion.times, positions, rotations.align_signs(orientations))

    def base(self, motion: MotionT) -> MotionT:
        """A motion that is seen from this frame, in the base frame.

        Args:
            motion: the motion in this frame; velocities of joints are rotated with it.
        """
        positions = motion.positions @ self.axes.T + self.origin
        if isinstance(motion, PoseTrajectory):
            orientations = rotations.compose(
                self.orientations(len(motion.times)), motion.orientations
            )
            orientations = rotations.align_signs(orientations)
            return replace(motion, positions=positions, orientations=orientations)
        if isinstance(motion, JointTrajectory):
            rates = [motion.velocities, motion.accelerations]
            velocities, accelerations = (None if r is None else r @ self.axes.T for r in rates)
            return replace(
                motion, positions=positions, velocities=velocities, accelerations=accelerations
            )
        return replace(motion, positions=positions)

    def orientations(self, count: int) -> Float64Array:
        """The frame's orientation, repeated.

        Args:
            count: number of rows.

        Returns:
            Orientations (count, 4), w, x, y, z.
        """
        return np.repeat(rotations.from_matrix(self.axes[None]), count, axis=0)


def checked_frames(
    frames: Sequence[Sequence[Frame]], count: int, size: int, *, poses: bool
) -> list[tuple[Frame, ...]]:
    """The frames of each of several demonstrations."""
    if not isinstance(frames, Sequence) or len(frames) != count:
        got = len(frames) if isinstance(frames, Sequence) else type(frames).__name__
        raise check.refused("frames", f"one sequence of frames per demonstration, {count}", got)
    given = [tuple(each) for each in frames]
    for frame in (frame for each in given for frame in each):
        if not isinstance(frame, Frame) or len(frame.origin) != size:
            got = len(frame.origin) if isinstance(frame, Frame) else type(frame).__name__
            raise InvalidInput(f"frames: expected frames of {size} dimensions, got {got}")
        if poses and np.linalg.det(frame.axes) < 0.0:
            raise InvalidInput("frames: expected right-handed axes for poses")
    if len({len(each) for each in given}) != 1 or not given[0]:
        numbers = sorted({len(each) for each in given})
        raise InvalidInput(
            "frames: expected the same number of frames for every demonstration, at least one, "
            f"got {', '.join(map(str, numbers))}"
        )
    return given
