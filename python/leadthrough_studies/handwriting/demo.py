"""Human handwriting, learned, planned around a box and written by a robot arm.

The demo learns six of the seven demonstrations of a motion of the LASA set and reproduces the
seventh from its start. Then it plans the motion around a box, places it on a table in front of a
UR3 that holds a pen, and computes a joint trajectory within the limits. Finally it checks the whole
arm and the pen against the table, the box and the arm itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from leadthrough.arm import Arm, CollisionReport
from leadthrough.check import Float64Array
from leadthrough.io import lasa
from leadthrough.models import FastMarching, FastMarchingSkill
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory, Trajectory
from leadthrough.preprocess.resample import by_arc_length
from leadthrough.shapes import Box, Capsule, Scene
from leadthrough.shapes.scene import PLANNING_TOLERANCE
from leadthrough.timing import LimitsReport, check_limits, keep_timing
from leadthrough_studies import metrics

MOTIONS = (
    "GShape", "Leaf_1", "Snake", "Sshape", "WShape", "BendedLine", "heee", "DoubleBendedLine",
)  # fmt: skip


@dataclass(frozen=True)
class HandwritingConfig:
    """The table, the pen and the box. Lengths are in m, in the arm's base frame.

    Attributes:
        robot: name of the arm.
        model: the model that learns the motion.
        centre: x and y of the centre of the drawing, on the table at z = 0.
        size: longer side of the drawing.
        pen_length: distance from the flange to the table.
        pen_radius: radius of the pen's collision shape.
        pen_lift: height above the table at which that shape ends.
        box_size: edges of the obstacle.
        hurry: factor by which the motion should be faster than the people drew it; the arm's limits
            then slow it down.
        posture: joint positions (joints,), rad, elbow up, from which the first pose is searched.
    """

    robot: str = "ur3"
    model: FastMarching = field(default_factory=FastMarching)
    centre: tuple[float, float] = (0.30, 0.0)
    size: float = 0.16
    pen_length: float = 0.10
    pen_radius: float = 0.001
    pen_lift: float = 0.001
    box_size: tuple[float, float, float] = (0.012, 0.012, 0.05)
    hurry: float = 10.0
    posture: tuple[float, ...] = (0.0, -1.6, 1.9, -1.9, -1.6, 0.0)


# Fraction of the pen's height above the table that the whole arm keeps clear of everything.
_OF_THE_LIFT = 0.5
_RATE = 100.0  # Hz, of the motion inside the limits


@dataclass(frozen=True, eq=False)
class Handwriting:
    """One motion, from the recordings to the joints; lengths in m on the table.

    Attributes:
        name: name of the motion in the LASA set.
        shown: the six motions that were learned.
        held_out: the seventh motion.
        skill: the learned skill.
        reproduction: the motion generated from the start of the seventh.
        box: the obstacle.
        detour: the motion planned around the obstacle.
        joints: the joint trajectory.
        slowing: the factor on time that brought the motion within the limits.
        limits: the check of the joint trajectory against the limits.
        errors: errors of the reproduction, in mm of the drawing.
        clearance: the collision check of arm and pen.
    """

    name: str
    shown: tuple[Trajectory, ...]
    held_out: Trajectory
    skill: FastMarchingSkill
    reproduction: Trajectory
    box: Box
    detour: Trajectory
    joints: JointTrajectory
    slowing: float
    limits: LimitsReport
    errors: metrics.ReproductionErrors
    clearance: CollisionReport

    @property
    def ok(self) -> bool:
        """Whether the motion keeps all limits and the arm is clear."""
        return self.limits.ok and self.clearance.ok


def run(name: str, arm: Arm, config: HandwritingConfig) -> Handwriting:
    """Learn and reproduce one motion, plan it around a box and compute the arm's joints."""
    drawings = [_drawing(demonstration) for demonstration in lasa.load(name)]
    placement = _Placement.onto_table(drawings, config)
    *shown, held_out = (placement.on_table(drawing) for drawing in drawings)
    skill = config.model.fit([Demonstration(motion) for motion in shown])
    start = held_out.positions[0]
    reproduction = skill.generate(start=start)
    box = _box_in_the_way(reproduction.positions, config)
    detour = skill.generate(start=start, obstacles=[box])
    poses = _hurried(_with_pen(detour, config), config)
    holding, around = arm.with_attached(pen(config)), [_table(), box]
    # Planning keeps the rest of the margin besides.
    scene = Scene(around, _OF_THE_LIFT * config.pen_lift - PLANNING_TOLERANCE)
    followed = holding.follow(
        poses,
        q0=config.posture,
        on_rate_limit="exceed_limits",
        scene=scene,
    )
    joints = keep_timing(followed, arm.limits, rate=_RATE)
    return Handwriting(
        name=name,
        shown=tuple(shown),
        held_out=held_out,
        skill=skill,
        reproduction=reproduction,
        box=box,
        detour=detour,
        joints=joints,
        slowing=joints.duration / followed.duration,
        limits=check_limits(joints, arm.limits),
        errors=metrics.reproduction_errors(drawings[-1], placement.on_paper(reproduction)),
        clearance=holding.check(joints, scene),
    )


@dataclass(frozen=True, eq=False)
class _Placement:
    """The map from a drawing in mm onto the table in m, and back."""

    scale: float
    offset: Float64Array

    @classmethod
    def onto_table(cls, drawings: Sequence[Trajectory], config: HandwritingConfig) -> _Placement:
        points = np.concatenate([drawing.positions for drawing in drawings])
        lower, upper = points.min(axis=0), points.max(axis=0)
        scale = config.size / float((upper - lower).max())
        return cls(scale, np.array(config.centre) - scale * 0.5 * (lower + upper))

    def on_table(self, drawing: Trajectory) -> Trajectory:
        return Trajectory(drawing.times, self.offset + self.scale * drawing.positions)

    def on_paper(self, motion: Trajectory) -> Trajectory:
        return Trajectory(motion.times, (motion.positions - self.offset) / self.scale)


def _drawing(demonstration: Demonstration) -> Trajectory:
    assert isinstance(demonstration.motion, Trajectory)
    return demonstration.motion


def _box_in_the_way(path: Float64Array, config: HandwritingConfig) -> Box:
    """A box on the middle half of the path, where both ends are farthest away."""
    even = by_arc_length(path, 101)
    middle = even[25:76]
    ends = np.minimum(*(np.linalg.norm(middle - end, axis=1) for end in even[[0, -1]]))
    x, y = middle[int(np.argmax(ends))]
    return Box(np.array(config.box_size), np.array([x, y, 0.0]))


def _table() -> Box:
    """The table on which the arm stands and draws."""
    return Box(np.array([1.2, 1.2, 0.04]), np.array([0.0, 0.0, -0.02]))


def pen(config: HandwritingConfig) -> Capsule:
    """The pen in the flange's frame, along its z."""
    length = config.pen_length - config.pen_lift
    middle = np.array([0.0, 0.0, 0.5 * length])
    return Capsule(config.pen_radius, length - 2.0 * config.pen_radius, middle)


def _hurried(motion: PoseTrajectory, config: HandwritingConfig) -> PoseTrajectory:
    return replace(motion, times=motion.times / config.hurry)


def _with_pen(motion: Trajectory, config: HandwritingConfig) -> PoseTrajectory:
    """Flange poses that hold a pen upright with its tip on the drawing."""
    count = len(motion.times)
    height = np.full((count, 1), config.pen_length)
    downwards = np.tile([0.0, 1.0, 0.0, 0.0], (count, 1))  # half a turn about x: flange down
    return PoseTrajectory(motion.times, np.hstack([motion.positions, height]), downwards)
