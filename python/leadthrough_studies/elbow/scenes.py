"""Reaches of an arm, and obstacles that stand where its links pass but not its tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.motion import JointTrajectory, PoseTrajectory
from leadthrough.shapes import Box, Cylinder, Shape, Sphere
from leadthrough.trajectories import minimum_jerk_rise

# Where the ends of the reaches lie, m in the arm's base frame.
SPACES = {
    "panda": ((0.3, -0.45, 0.15), (0.6, 0.45, 0.55)),
    "ur3": ((-0.35, 0.15, 0.05), (0.35, 0.35, 0.3)),
}
FREE: dict[str, tuple[Literal["rz"], ...]] = {
    "panda": (),
    "ur3": ("rz",),
}  # the UR3's tool may spin about its own axis
_DOWN = (0.0, 1.0, 0.0, 0.0)
_SAMPLES, _DURATION, _SHORTEST = 81, 3.0, 0.25  # s, m
_OFF_THE_TIP, _OFF_THE_BASE, _IN_THE_WAY = 0.05, 0.15, 0.005  # m
_SIZES = (0.04, 0.15)  # m


@dataclass(frozen=True, eq=False)
class Scene:
    """A reach among obstacles that the arm touches if it does not look at them.

    Attributes:
        tip: the motion of the tip.
        joints: the arm along it without the obstacles.
        obstacles: at least 5 cm off the tip's path.
    """

    tip: PoseTrajectory
    joints: JointTrajectory
    obstacles: tuple[Shape, ...]


def scene(arm: Arm, name: str, rng: np.random.Generator) -> Scene:
    """A random reach of the arm, with one to four obstacles in its way."""
    while True:
        tip = _reach(name, rng)
        try:
            joints = arm.follow(tip, free=FREE[name])
        except IkFailure:
            continue
        found = [_in_the_way(arm, tip, joints, rng) for _ in range(rng.integers(1, 5))]
        if obstacles := tuple(each for each in found if each is not None):
            return Scene(tip, joints, obstacles)


def _reach(name: str, rng: np.random.Generator) -> PoseTrajectory:
    low, high = np.array(SPACES[name])
    while True:
        ends = rng.uniform(low, high, (2, 3))
        if np.linalg.norm(ends[1] - ends[0]) > _SHORTEST:
            break
    u = np.linspace(0.0, 1.0, _SAMPLES)
    bow = np.outer(np.sin(np.pi * u), rng.uniform(-0.08, 0.08, 3))
    way = ends[0] + np.outer(minimum_jerk_rise(u), ends[1] - ends[0]) + bow
    return PoseTrajectory(_DURATION * u, way, np.tile(_DOWN, (_SAMPLES, 1)))


def _in_the_way(
    arm: Arm, tip: PoseTrajectory, joints: JointTrajectory, rng: np.random.Generator
) -> Shape | None:
    """A shape that the arm touches on its way; None if none was found."""
    for _ in range(60):
        shape = _shape(rng.uniform((-0.6, -0.6, -0.1), (0.6, 0.6, 1.1)), rng)
        if shape.distance(np.zeros((1, 3)))[0] < _OFF_THE_BASE:
            continue
        if shape.distance(tip.positions).min() < _OFF_THE_TIP:
            continue
        if np.min(arm.distance(joints.positions[::5], [shape])) < -_IN_THE_WAY:
            return shape
    return None


def _shape(place: Float64Array, rng: np.random.Generator) -> Shape:
    size = rng.uniform(*_SIZES, 3)
    kind = rng.integers(3)
    if kind == 0:
        return Box(size, place)
    if kind == 1:
        return Sphere(0.5 * size[0] + 0.02, place)
    return Cylinder(0.5 * size[0], 2.0 * size[1], place)
