"""Tasks that keep a distance: from joint limits and from obstacles; see `task`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core
from leadthrough.arm import magnitudes, task
from leadthrough.arm.task import ZERO, ArmTask, FrameOf
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.shapes import Shape


@dataclass(frozen=True, eq=False, init=False)
class JointLimitTask(ArmTask):
    """The joints away from their limits, softly: the hard limits hold in any case.

    Attributes:
        margin: distance from a limit in rad or m at which the task begins to act, > 0; at most a
            quarter of a joint's range counts.
        gain: fraction per second of what is left of the distance that it may shrink by, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if a number is out of its range.
    """

    margin: float

    def __init__(
        self, *, margin: float = 0.1, gain: float = 5.0, damping_ratio: float = 1.0
    ) -> None:
        super().__init__(gain, damping_ratio)
        vars(self).update(margin=magnitudes.positive(margin, "margin"))

    def _compiled(self, _frame_of: FrameOf) -> _core.ArmTask:
        return _core.joint_limit_task(self.margin, self.gain, self.damping_ratio)


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
        damping_ratio: of the decay where accelerations are commanded, > 0.

    Raises:
        InvalidInput: if an argument has another type or shape, or is out of its range.
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
        if not isinstance(shape, Shape):
            what = type(shape).__name__
            raise InvalidInput(f"shape: expected one of leadthrough.shapes, got {what}")
        _refuse_huge(shape)
        vars(self).update(
            shape=shape,
            distance=magnitudes.not_negative(distance, "distance"),
            margin=magnitudes.positive(margin, "margin"),
            link=link,
            point=task.vector(point, "point", 3),
        )

    def _compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame, shape = frame_of(self.link, self.point), self.shape._compiled
        rates = (self.gain, self.damping_ratio)
        return _core.clearance_task(frame, shape, self.distance, self.margin, *rates)


def _refuse_huge(shape: Shape) -> None:
    names = ("position", "size", "radius", "length", "vertices", "points")
    sizes = [np.ravel(getattr(shape, name, 0.0)) for name in names]
    magnitudes.values(np.concatenate(sizes), "shape", shape=("n",))
