"""Frames that move with a task, and motions and distributions seen from them.

Points and joints seen from a frame are shifted and turned. Of poses the orientation is seen from
it too: as a rotation vector in the tangent spaces along the frame's own reference. Where the frames
of a new situation stand, these references are averaged; each frame's Gaussians are brought into the
tangent spaces of the mean to first order. Source: Zeestraten et al. 2017, "An approach for
imitation learning on Riemannian manifolds", section III-C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.chart import NODES, Chart, mean_orientations
from leadthrough.motion import Motion, PoseTrajectory

_ORTHONORMAL = 1e-6
# Half the span of phases over which a drift is measured.
_AROUND = 2.5e-3


@dataclass(frozen=True, eq=False)
class Frame:
    """Where something of the task stands: a start, a goal, an object.

    origin: (d,). axes: (d, d) orthonormal, its axes as columns; by default those of the base frame.
    For poses (3,) and (3, 3), right-handed.
    """

    origin: Float64Array
    axes: Any = None

    def __post_init__(self) -> None:
        origin = check.frozen(self.origin, "origin", shape=("d",))
        size = len(origin)
        given = np.eye(size) if self.axes is None else self.axes
        axes = check.frozen(given, "axes", shape=(size, size))
        if np.abs(axes.T @ axes - np.eye(size)).max() > _ORTHONORMAL:
            raise InvalidInput("axes: expected orthonormal columns")
        object.__setattr__(self, "origin", origin)
        object.__setattr__(self, "axes", axes)

    @staticmethod
    def of_pose(position: Float64Array, orientation: Float64Array) -> Frame:
        """The frame of a tool at a position (3,) with an orientation (4,)."""
        return Frame(position, rotations.to_matrix(orientation[None])[0])

    def local(self, motion: Motion) -> Motion:
        """A motion of the base frame, seen from this one; without events and derivatives."""
        positions = np.asarray((motion.positions - self.origin) @ self.axes)
        if not isinstance(motion, PoseTrajectory):
            return type(motion)(motion.times, positions)
        back = rotations.inverse(self.orientations(len(motion.times)))
        turned = rotations.compose(back, motion.orientations)
        return PoseTrajectory(motion.times, positions, rotations.align_signs(turned))

    def orientations(self, count: int) -> Float64Array:
        """Its orientation, repeated (count, 4)."""
        return np.repeat(rotations.from_matrix(self.axes[None]), count, axis=0)


@dataclass(frozen=True, eq=False)
class Placed:
    """Gaussians of a frame in a situation: means (k, w), what turns their deviations (k, w, w).

    drift: (k, w) what the means gain a second because the reference moves on.
    """

    means: Float64Array
    maps: Float64Array
    drift: Float64Array


def common_chart(chart: Chart, own: Sequence[Chart], frames: Sequence[Frame]) -> Chart:
    """The chart about the mean of the frames' references, which are those of their own charts."""
    if chart.kind != "poses":
        return chart
    predicted = [_predicted(each, frame, NODES) for each, frame in zip(own, frames, strict=True)]
    return replace(chart, reference=mean_orientations(predicted))


def placed(frame: Frame, own: Chart, common: Chart, means: Float64Array, duration: float) -> Placed:
    """Gaussians with means (k, 1 + w), the time first, s, in a frame's own columns, in common ones.

    duration: s, of the motion.
    """
    size, count = own.size, len(means)
    means, phases = means[:, 1:], np.clip(means[:, 0] / duration, 0.0, 1.0)
    moved = means[:, :size] @ frame.axes.T + frame.origin
    if own.kind != "poses":
        maps = np.broadcast_to(frame.axes, (count, size, size))
        return Placed(moved, maps, np.zeros_like(moved))

    def tangent(at: Float64Array) -> Float64Array:
        turned = rotations.compose(_predicted(own, frame, at), rotations.exp(means[:, 3:]))
        return common.tangent(turned, at)

    here = tangent(phases)
    before, after = np.maximum(phases - _AROUND, 0.0), np.minimum(phases + _AROUND, 1.0)
    drift = (tangent(after) - tangent(before)) / (duration * (after - before))[:, None]
    maps = np.zeros((count, 6, 6))
    maps[:, :3, :3] = frame.axes
    # log(exp(d) exp(v)) = d + J_r(d)^-1 v + ..., with J_r(d) = J_l(-d); Sola et al. 2018, eq. 151.
    maps[:, 3:, 3:] = rotations.left_jacobian_inverse(-here) @ rotations.left_jacobian(
        -means[:, 3:]
    )
    return Placed(np.hstack([moved, here]), maps, np.hstack([np.zeros((count, 3)), drift]))


def checked(frames: Sequence[Sequence[Frame]], count: int, chart: Chart) -> list[tuple[Frame, ...]]:
    """Frames for so many demonstrations, as many for each. Raises InvalidInput."""
    if not isinstance(frames, Sequence) or len(frames) != count:
        raise InvalidInput(f"frames: expected a sequence for each of {count} demonstrations")
    given = [tuple(each) for each in frames]
    for frame in (frame for each in given for frame in each):
        if not isinstance(frame, Frame) or len(frame.origin) != chart.size:
            raise InvalidInput(f"frames: expected Frame of {chart.size} dimensions")
        if chart.kind == "poses" and np.linalg.det(frame.axes) < 0.0:
            raise InvalidInput("frames: expected right-handed axes for poses")
    if len({len(each) for each in given}) != 1 or not given[0]:
        raise InvalidInput("frames: expected as many for every demonstration, at least one")
    return given


def _predicted(own: Chart, frame: Frame, phases: Float64Array) -> Float64Array:
    """A frame's reference orientation (n, 4) in the base frame."""
    return rotations.compose(frame.orientations(len(phases)), own.reference_at(phases))
