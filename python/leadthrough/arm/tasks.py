"""Tasks for an arm: to reach a pose, position, direction or posture, or to keep a distance.

A task that reaches wants its error to decay at `gain`, 1/s: in velocities like exp(-gain t), in
accelerations like a second-order system of that frequency and `damping_ratio` (De Luca, Oriolo and
Siciliano 1992). A task that keeps a distance (a cone, joint limits, an obstacle) is unilateral: the
distance may shrink no faster than `gain` times its remainder (the velocity damper of Faverjon and
Tournassoud 1987). It begins to act `margin` before its limit and acts fully from half of that.

Source: Siciliano and Slotine 1991 for tasks with priorities.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import magnitudes
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.shapes import Shape

# m/s and rad/s, or a point: nothing along any axis.
ZERO = (0.0, 0.0, 0.0)
STILL = (*ZERO, *ZERO)
# The same as arrays: loops make tasks in every step, and what is left out need not be checked anew.
_NOTHING = {
    len(axes): magnitudes.frozen(axes, "axes", shape=(len(axes),)) for axes in (ZERO, STILL)
}

# The frame of a link, at a point given in it.
FrameOf = Callable[[str | None, Float64Array], core.Frame]


@dataclass(frozen=True, eq=False, init=False)
class ArmTask(ShortRepr, ABC):
    """A task for a `TaskStack`: something to reach, or to keep away from.

    Attributes:
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0; 1 is critical.
    """

    gain: float
    damping_ratio: float

    def __init__(self, gain: float, damping_ratio: float) -> None:
        vars(self).update(
            gain=magnitudes.positive(gain, "gain"),
            damping_ratio=magnitudes.positive(damping_ratio, "damping_ratio"),
        )

    @abstractmethod
    def _compiled(self, frame_of: FrameOf) -> core.ArmTask:
        """The task as the core takes it."""


def _vector(value: ArrayLike, name: str, size: int) -> Float64Array:
    """A read-only copy (size,) of a value of moderate size."""
    if (value is ZERO or value is STILL) and len(value) == size:
        return _NOTHING[size]
    return magnitudes.frozen(value, name, shape=(size,))


def _unit_vector(value: ArrayLike, name: str) -> Float64Array:
    """A read-only unit vector (3,)."""
    given = check.array(value, name, shape=(3,))
    largest = float(np.abs(given).max())
    if largest == 0.0:
        raise InvalidInput(f"{name}: expected a direction, got the zero vector")
    scaled = given / largest
    return check.freeze(np.asarray(scaled / np.linalg.norm(scaled)))


@dataclass(frozen=True, eq=False, init=False)
class PoseTask(ArmTask):
    """A link's frame at a pose in the base frame.

    Attributes:
        position: (3,) in m.
        orientation: (4,) w, x, y, z.
        twist: of the goal, (6,) in m/s and rad/s, linear first.
        link: name of the link; None is the arm's tip.
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
        unit = check.quaternions(orientation, "orientation", shape=(4,))
        vars(self).update(
            position=_vector(position, "position", 3),
            orientation=check.freeze(unit),
            twist=_vector(twist, "twist", 6),
            link=link,
        )

    def _compiled(self, frame_of: FrameOf) -> core.ArmTask:
        frame = frame_of(self.link, _vector(ZERO, "point", 3))
        pose = (self.position, self.orientation, self.twist)
        return core.pose_task(frame, *pose, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class PositionTask(ArmTask):
    """A point of a link at a position in the base frame.

    Attributes:
        position: (3,) in m.
        velocity: of the goal, (3,) in m/s.
        link: name of the link; None is the arm's tip.
        point: (3,) in m, in the link's frame.
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
            position=_vector(position, "position", 3),
            velocity=_vector(velocity, "velocity", 3),
            link=link,
            point=_vector(point, "point", 3),
        )

    def _compiled(self, frame_of: FrameOf) -> core.ArmTask:
        frame = frame_of(self.link, self.point)
        goal = (self.position, self.velocity)
        return core.position_task(frame, *goal, self.gain, self.damping_ratio)


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
            axis=_unit_vector(axis, "axis"),
            direction=_unit_vector(direction, "direction"),
            within=check.number(within, "within", at_least=0.0, below=math.pi),
            margin=check.number(margin, "margin", above=0.0, at_most=math.pi),
            link=link,
        )

    def _compiled(self, frame_of: FrameOf) -> core.ArmTask:
        frame, ends = frame_of(self.link, np.zeros(3)), (self.axis, self.direction)
        rates = (self.gain, self.damping_ratio)
        if self.within == 0.0:
            return core.direction_task(frame, *ends, *rates)
        cosine = math.cos(self.within)
        margin = math.cos(max(self.within - self.margin, 0.0)) - cosine
        return core.cone_task(frame, *ends, cosine, margin, *rates)


@dataclass(frozen=True, eq=False, init=False)
class PostureTask(ArmTask):
    """The joints at a configuration; usually the lowest task.

    Attributes:
        q: (joints,) in rad (m for prismatic joints).
        velocity: of the goal, (joints,) in rad/s (m/s).
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
        vars(self).update(q=goal, velocity=_vector(still, "velocity", len(goal)))

    def _compiled(self, _frame_of: FrameOf) -> core.ArmTask:
        return core.posture_task(self.q, self.velocity, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class ElbowTask(ArmTask):
    """The origin of a middle link in the plane direction . x = height.

    Attributes:
        link: name of the link.
        height: in m.
        direction: normal of the plane, (3,) in the base frame, whose length doesn't matter.
            (0, 0, 1), the default, sets the elbow's height; a horizontal direction swings it
            sideways.
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
            direction=_unit_vector(direction, "direction"),
        )

    def _compiled(self, frame_of: FrameOf) -> core.ArmTask:
        frame = frame_of(self.link, np.zeros(3))
        return core.plane_task(frame, self.direction, self.height, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class JointLimitTask(ArmTask):
    """The joints away from their limits, softly: the hard limits hold in any case.

    Attributes:
        margin: distance from a limit in rad or m at which the task begins to act, > 0; at most a
            quarter of a joint's range counts.
        gain: fraction per second of what is left of the distance that it may shrink by, > 0.
    """

    margin: float

    def __init__(
        self, *, margin: float = 0.1, gain: float = 5.0, damping_ratio: float = 1.0
    ) -> None:
        super().__init__(gain, damping_ratio)
        vars(self).update(margin=magnitudes.positive(margin, "margin"))

    def _compiled(self, _frame_of: FrameOf) -> core.ArmTask:
        return core.joint_limit_task(self.margin, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False, init=False)
class ObstacleTask(ArmTask):
    """A point of a link at least some distance away from a shape.

    Attributes:
        shape: one of `leadthrough.shapes` in the base frame.
        distance: to keep in m, >= 0; for a ball around the point add its radius.
        margin: additional distance in m at which the task begins to act, > 0.
        link: name of the link; None is the arm's tip.
        point: (3,) in m, in the link's frame.
        gain: fraction per second of what is left of the distance that it may shrink by, > 0.
    """

    shape: Shape
    distance: float
    margin: float
    link: str | None
    point: Float64Array

    def __init__(
        self,
        shape: Shape,
        distance: float,
        *,
        margin: float = 0.05,
        link: str | None = None,
        point: ArrayLike = ZERO,
        gain: float = 5.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(gain, damping_ratio)
        check.instance(shape, "shape", Shape, "one of leadthrough.shapes")
        names = ("position", "size", "radius", "length", "vertices", "points")
        sizes = [np.ravel(getattr(shape, name, 0.0)) for name in names]
        magnitudes.values(np.concatenate(sizes), "shape", shape=("n",))
        vars(self).update(
            shape=shape,
            distance=magnitudes.not_negative(distance, "distance"),
            margin=magnitudes.positive(margin, "margin"),
            link=link,
            point=_vector(point, "point", 3),
        )

    def _compiled(self, frame_of: FrameOf) -> core.ArmTask:
        frame, shape = frame_of(self.link, self.point), self.shape._compiled
        rates = (self.gain, self.damping_ratio)
        return core.clearance_task(frame, shape, self.distance, self.margin, *rates)
