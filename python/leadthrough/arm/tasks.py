"""Tasks for an arm: what to reach, and what to keep away from.

A task that reaches wants its error to decay at `gain`, 1/s: in velocities like exp(-gain t), in
accelerations like a second-order system of that frequency and `damping_ratio` (De Luca, Oriolo and
Siciliano 1992). A task that keeps (a cone, joint limits, an obstacle) is unilateral: its distance
may shrink no faster than at `gain` times what is left (the velocity damper of Faverjon and
Tournassoud 1987), it begins to act `margin` before its limit and acts in full from half of it on.

link: the link whose frame the task is about; None is the arm's tip. Frames and directions are in
the base frame, m and rad; quaternions w, x, y, z. Every task raises InvalidInput.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.arm import magnitudes
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.shapes import Box, Capsule, Shape, Sphere

_STILL = (0.0, 0.0, 0.0)

# The frame of a link, at a point given in it.
FrameOf = Callable[[str | None, Float64Array], _core.Frame]


@dataclass(frozen=True, eq=False)
class _Task:
    _: KW_ONLY
    gain: float = 5.0
    damping_ratio: float = 1.0

    def __post_init__(self) -> None:
        _set(self, "gain", magnitudes.positive(self.gain, "gain"))
        ratio = magnitudes.positive(self.damping_ratio, "damping_ratio")
        _set(self, "damping_ratio", ratio)


@dataclass(frozen=True, eq=False)
class PoseTask(_Task):
    """A link's frame at a pose. position: (3,). orientation: (4,). twist: (6,) of the goal."""

    position: Float64Array
    orientation: Float64Array
    _: KW_ONLY
    twist: Float64Array = (0.0,) * 6  # type: ignore[assignment]
    link: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _freeze(self, position=3, twist=6)
        _set(self, "orientation", _quaternion(self.orientation))

    def compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame = frame_of(self.link, np.zeros(3))
        pose = (self.position, self.orientation, self.twist)
        return _core.pose_task(frame, *pose, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False)
class PositionTask(_Task):
    """A point of a link at a position. point: (3,) in the link's frame. velocity: of the goal."""

    position: Float64Array
    _: KW_ONLY
    velocity: Float64Array = _STILL  # type: ignore[assignment]
    link: str | None = None
    point: Float64Array = _STILL  # type: ignore[assignment]

    def __post_init__(self) -> None:
        super().__post_init__()
        _freeze(self, position=3, velocity=3, point=3)

    def compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame = frame_of(self.link, self.point)
        goal = (self.position, self.velocity)
        return _core.position_task(frame, *goal, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False)
class DirectionTask(_Task):
    """An axis of a link along a direction, or within an angle of it.

    axis: (3,) in the link's frame. direction: (3,) in the base frame. within: rad, 0 to pi; 0
    aligns the axis, more keeps it inside a cone. margin: rad. Of lengths only the sign matters.
    """

    axis: Float64Array
    direction: Float64Array
    _: KW_ONLY
    within: float = 0.0
    margin: float = 0.2
    link: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _set(self, "axis", _unit(self.axis, "axis"))
        _set(self, "direction", _unit(self.direction, "direction"))
        within = check.number(self.within, "within", at_least=0.0, below=math.pi)
        _set(self, "within", within)
        _set(self, "margin", check.number(self.margin, "margin", above=0.0, at_most=math.pi))

    def compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame, ends = frame_of(self.link, np.zeros(3)), (self.axis, self.direction)
        rates = (self.gain, self.damping_ratio)
        if self.within == 0.0:
            return _core.direction_task(frame, *ends, *rates)
        cosine = math.cos(self.within)
        margin = math.cos(max(self.within - self.margin, 0.0)) - cosine
        return _core.cone_task(frame, *ends, cosine, margin, *rates)


@dataclass(frozen=True, eq=False)
class PostureTask(_Task):
    """The joints at q, (joints,); usually the lowest task. velocity: (joints,) of the goal."""

    q: Float64Array
    _: KW_ONLY
    velocity: Float64Array | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _set(self, "q", magnitudes.frozen(self.q, "q", shape=("joints",)))
        still = np.zeros_like(self.q) if self.velocity is None else self.velocity
        _set(self, "velocity", magnitudes.frozen(still, "velocity", shape=(len(self.q),)))

    def compiled(self, _frame_of: FrameOf) -> _core.ArmTask:
        assert self.velocity is not None
        return _core.posture_task(self.q, self.velocity, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False)
class JointLimitTask(_Task):
    """The joints away from their limits, softly: the hard limits hold in any case.

    margin: rad or m, at most a quarter of a joint's range.
    """

    _: KW_ONLY
    margin: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        _set(self, "margin", magnitudes.positive(self.margin, "margin"))

    def compiled(self, _frame_of: FrameOf) -> _core.ArmTask:
        return _core.joint_limit_task(self.margin, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False)
class ElbowTask(_Task):
    """A middle link's origin on the plane direction . x = height, m.

    direction: (3,), of which the length does not matter. (0, 0, 1), the default, sets the elbow's
    height; a horizontal direction swings it sideways.
    """

    link: str
    height: float
    _: KW_ONLY
    direction: Float64Array = (0.0, 0.0, 1.0)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        super().__post_init__()
        _set(self, "height", float(magnitudes.values(self.height, "height", shape=())))
        _set(self, "direction", _unit(self.direction, "direction"))

    def compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame = frame_of(self.link, np.zeros(3))
        return _core.plane_task(frame, self.direction, self.height, self.gain, self.damping_ratio)


@dataclass(frozen=True, eq=False)
class ObstacleTask(_Task):
    """A point of a link at least `distance` from a shape.

    distance: m, >= 0; for a ball about the point add its radius. point: (3,) in the link's frame.
    margin: m.
    """

    shape: Shape
    distance: float
    _: KW_ONLY
    margin: float = 0.05
    link: str | None = None
    point: Float64Array = _STILL  # type: ignore[assignment]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.shape, Box | Sphere | Capsule):
            what = type(self.shape).__name__
            raise InvalidInput(f"shape: expected a Box, Sphere or Capsule, got {what}")
        _refuse_huge(self.shape)
        _set(self, "distance", magnitudes.not_negative(self.distance, "distance"))
        _set(self, "margin", magnitudes.positive(self.margin, "margin"))
        _freeze(self, point=3)

    def compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        frame, shape = frame_of(self.link, self.point), _compiled_shape(self.shape)
        rates = (self.gain, self.damping_ratio)
        return _core.clearance_task(frame, shape, self.distance, self.margin, *rates)


Task = (
    PoseTask
    | PositionTask
    | DirectionTask
    | PostureTask
    | JointLimitTask
    | ElbowTask
    | ObstacleTask
)


def _compiled_shape(shape: Shape) -> _core.Shape:
    if isinstance(shape, Box):
        return _core.box_shape(shape.size, shape.position, shape.orientation)
    if isinstance(shape, Sphere):
        return _core.sphere_shape(shape.radius, shape.position)
    return _core.capsule_shape(shape.radius, shape.length, shape.position, shape.orientation)


def _refuse_huge(shape: Shape) -> None:
    sizes = [getattr(shape, name, 0.0) for name in ("position", "size", "radius", "length")]
    magnitudes.values(np.hstack(sizes), "shape", shape=("n",))


def _set(task: _Task, name: str, value: Any) -> None:
    object.__setattr__(task, name, value)


def _freeze(task: _Task, **lengths: int) -> None:
    for name, length in lengths.items():
        _set(task, name, magnitudes.frozen(getattr(task, name), name, shape=(length,)))


def _quaternion(value: Any) -> Float64Array:
    unit = check.quaternions(value, "orientation", shape=(4,))
    unit.setflags(write=False)
    return unit


def _unit(value: Any, name: str) -> Float64Array:
    vector = check.array(value, name, shape=(3,))
    largest = float(np.abs(vector).max())
    if largest == 0.0:
        raise InvalidInput(f"{name}: expected a direction, got {vector}")
    vector = vector / largest
    unit = np.asarray(vector / np.linalg.norm(vector))
    unit.setflags(write=False)
    return unit
