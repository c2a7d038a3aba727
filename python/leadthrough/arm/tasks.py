"""Tasks that reach: a pose, a position, a direction, a posture, an elbow's height.

What they ask for is in `task`. Source: Siciliano and Slotine 1991 for tasks with priorities.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm import magnitudes, task
from leadthrough.arm.task import STILL, ZERO, ArmTask, FrameOf
from leadthrough.check import Float64Array


@dataclass(frozen=True, eq=False, init=False)
class PoseTask(ArmTask):
    """A link's frame at a pose in the base frame.

    Attributes:
        position: (3,) in m.
        orientation: (4,) w, x, y, z.
        twist: of the goal, (6,) in m/s and rad/s, linear first.
        link: name of the link; None is the arm's tip.
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if an argument has another shape or is out of its range.
    """

    position: Float64Array
    orientation: Float64Array
    twist: Float64Array
    link: str | None

    def __init__(
        self,
        position: ArrayLike,
        orientation: ArrayLike,
        *,
        twist: ArrayLike = STILL,
        link: str | None = None,
        gain: float = 5.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(gain, damping_ratio)
        vars(self).update(
            position=task.vector(position, "position", 3),
            orientation=task.orientation(orientation),
            twist=task.vector(twist, "twist", 6),
            link=link,
        )

    def _compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame = frame_of(self.link, task.vector(ZERO, "point", 3))
        pose = (self.position, self.orientation, self.twist)
        return _core.pose_task(frame, *pose, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class PositionTask(ArmTask):
    """A point of a link at a position in the base frame.

    Attributes:
        position: (3,) in m.
        velocity: of the goal, (3,) in m/s.
        link: name of the link; None is the arm's tip.
        point: (3,) in m, in the link's frame.
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if an argument has another shape or is out of its range.
    """

    position: Float64Array
    velocity: Float64Array
    link: str | None
    point: Float64Array

    def __init__(
        self,
        position: ArrayLike,
        *,
        velocity: ArrayLike = ZERO,
        link: str | None = None,
        point: ArrayLike = ZERO,
        gain: float = 5.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(gain, damping_ratio)
        vars(self).update(
            position=task.vector(position, "position", 3),
            velocity=task.vector(velocity, "velocity", 3),
            link=link,
            point=task.vector(point, "point", 3),
        )

    def _compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame = frame_of(self.link, self.point)
        goal = (self.position, self.velocity)
        return _core.position_task(frame, *goal, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class DirectionTask(ArmTask):
    """An axis of a link along a direction, or within an angle of it.

    Of `axis` and `direction` the lengths don't matter.

    Attributes:
        axis: (3,) in the link's frame.
        direction: (3,) in the base frame.
        within: largest angle between the two in rad, 0 to pi; 0 aligns the axis, more keeps it
            inside a cone.
        margin: angle in rad before the cone's edge at which the task begins to act.
        link: name of the link; None is the arm's tip.
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if an argument has another shape or is out of its range.
    """

    axis: Float64Array
    direction: Float64Array
    within: float
    margin: float
    link: str | None

    def __init__(
        self,
        axis: ArrayLike,
        direction: ArrayLike,
        *,
        within: float = 0.0,
        margin: float = 0.2,
        link: str | None = None,
        gain: float = 5.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(gain, damping_ratio)
        vars(self).update(
            axis=task.direction(axis, "axis"),
            direction=task.direction(direction, "direction"),
            within=check.number(within, "within", at_least=0.0, below=math.pi),
            margin=check.number(margin, "margin", above=0.0, at_most=math.pi),
            link=link,
        )

    def _compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame, ends = frame_of(self.link, np.zeros(3)), (self.axis, self.direction)
        rates = (self.gain, self.damping_ratio)
        if self.within == 0.0:
            return _core.direction_task(frame, *ends, *rates)
        cosine = math.cos(self.within)
        margin = math.cos(max(self.within - self.margin, 0.0)) - cosine
        return _core.cone_task(frame, *ends, cosine, margin, *rates)


@dataclass(frozen=True, eq=False, init=False)
class PostureTask(ArmTask):
    """The joints at a configuration; usually the lowest task.

    Attributes:
        q: (joints,) in rad (m for prismatic joints).
        velocity: of the goal, (joints,) in rad/s (m/s).
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if an argument has another shape or is out of its range.
    """

    q: Float64Array
    velocity: Float64Array

    def __init__(
        self,
        q: ArrayLike,
        *,
        velocity: ArrayLike | None = None,
        gain: float = 5.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(gain, damping_ratio)
        goal = magnitudes.frozen(q, "q", shape=("joints",))
        still = np.zeros_like(goal) if velocity is None else velocity
        vars(self).update(q=goal, velocity=task.vector(still, "velocity", len(goal)))

    def _compiled(self, _frame_of: FrameOf) -> _core.ArmTask:
        return _core.posture_task(self.q, self.velocity, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class ElbowTask(ArmTask):
    """The origin of a middle link in the plane direction . x = height.

    Attributes:
        link: name of the link.
        height: in m.
        direction: normal of the plane, (3,) in the base frame, whose length doesn't matter.
            (0, 0, 1), the default, sets the elbow's height; a horizontal direction swings it
            sideways.
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if an argument has another shape or is out of its range.
    """

    link: str
    height: float
    direction: Float64Array

    def __init__(
        self,
        link: str,
        height: float,
        *,
        direction: ArrayLike = (0.0, 0.0, 1.0),
        gain: float = 5.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(gain, damping_ratio)
        vars(self).update(
            link=link,
            height=float(magnitudes.values(height, "height", shape=())),
            direction=task.direction(direction, "direction"),
        )

    def _compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame = frame_of(self.link, np.zeros(3))
        return _core.plane_task(frame, self.direction, self.height, self.gain, self.damping_ratio)
