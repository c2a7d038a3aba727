"""Motions of an arm's tip, and obstacles that stand where its links pass but not its tip.

The motions are reaches, or demonstrations by hand with a Panda in its own frame: Auddy et al. 2023,
"Continual learning from demonstration of robotics skills", data set RoboTasks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm, FollowOptions
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.motion import JointTrajectory, PoseTrajectory
from leadthrough.shapes import Box, Cylinder, Scene, Shape, Sphere
from leadthrough.shapes.scene import PLANNING_TOLERANCE
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough_studies.robotasks.study import read

# Regions of the reaches' ends, m in the arm's base frame.
SPACES = {
    "panda": ((0.3, -0.45, 0.15), (0.6, 0.45, 0.55)),
    "ur3": ((-0.35, 0.15, 0.05), (0.35, 0.35, 0.3)),
}
FREE: dict[str, tuple[Literal["rz"], ...]] = {
    "panda": (),
    "ur3": ("rz",),
}  # the UR3's tool may spin about its own axis
MARGIN = 0.005  # m that the arm is to keep from obstacles
_DOWN = (0.0, 1.0, 0.0, 0.0)
_SAMPLES, _DURATION, _SHORTEST = 81, 3.0, 0.25  # s, m
_OFF_THE_TIP, _OFF_THE_BASE, _IN_THE_WAY = 0.05, 0.15, 0.005  # m
_SIZES = (0.04, 0.15)  # m
# By how much a demonstration is moved to the sides, m, and turned about the base's axis, rad.
_MOVED, _TURNED = 0.04, 0.6


@dataclass(frozen=True, eq=False)
class Reach:
    """A reach among obstacles that the arm touches if it does not look at them.

    Attributes:
        tip: the motion of the tip.
        joints: the arm along it without the obstacles.
        obstacles: at least 5 cm off the tip's path.
    """

    tip: PoseTrajectory
    joints: JointTrajectory
    obstacles: tuple[Shape, ...]


def drawn_scene(arm: Arm, name: str, seed: int, index: int, files: Sequence[str]) -> Reach:
    """The scene of an index, on demonstrations in files of RoboTasks; on a reach without any."""
    shown = [each.motion for file in files for each in read(file)]
    return scene(arm, name, np.random.default_rng([seed, index]), shown)


def followed(arm: Arm, name: str, made: Reach) -> JointTrajectory:
    """The arm along a scene's path with the whole of it clear: what the study judges.

    Raises:
        IkFailure: if it finds no way.
    """
    seed = made.joints.positions[0]
    scene = Scene(made.obstacles, MARGIN - PLANNING_TOLERANCE)  # planning keeps the rest besides
    return arm.follow(made.tip, q0=seed, options=FollowOptions(free=FREE[name]), scene=scene)


def scene(
    arm: Arm, name: str, rng: np.random.Generator, shown: Sequence[PoseTrajectory] = ()
) -> Reach:
    """A random motion of the arm, with one to four obstacles in its way.

    Args:
        arm: the arm.
        name: its name, a key of SPACES.
        rng: random numbers.
        shown: demonstrations, one of which is moved and turned a little; without any, a reach is
            drawn.
    """
    while True:
        tip = _placed(shown, rng) if shown else _reach(name, rng)
        try:
            joints = arm.follow(tip, options=FollowOptions(free=FREE[name]))
        except IkFailure:
            continue
        found = [_in_the_way(arm, tip, joints, rng) for _ in range(rng.integers(1, 5))]
        if obstacles := tuple(each for each in found if each is not None):
            return Reach(tip, joints, obstacles)


def _reach(name: str, rng: np.random.Generator) -> PoseTrajectory:
    low, high = np.array(SPACES[name])
    while True:
        ends = rng.uniform(low, high, (2, 3))
        if np.linalg.norm(ends[1] - ends[0]) > _SHORTEST:
            break
    u = np.linspace(0.0, 1.0, _SAMPLES)
    bow = np.outer(np.sin(np.pi * u), rng.uniform(-0.08, 0.08, 3))
    way = ends[0] + np.outer(minimum_jerk_time_scaling(u), ends[1] - ends[0]) + bow
    return PoseTrajectory(_DURATION * u, way, np.tile(_DOWN, (_SAMPLES, 1)))


def _placed(shown: Sequence[PoseTrajectory], rng: np.random.Generator) -> PoseTrajectory:
    one = shown[int(rng.integers(len(shown)))]
    kept = np.linspace(0, len(one) - 1, _SAMPLES).round().astype(int)
    angle = rng.uniform(-_TURNED, _TURNED)
    turn = np.array([np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)])
    way = one.positions[kept] @ rotations.to_matrix(turn[None])[0].T
    return PoseTrajectory(
        one.times[kept],
        way + rng.uniform(-_MOVED, _MOVED, 3),
        rotations.compose(np.tile(turn, (_SAMPLES, 1)), one.orientations[kept]),
    )


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
