"""A Panda carries a jug to a glass that stands elsewhere than shown, around a bottle, and pours.

If LEADTHROUGH_DATA names a folder with the recordings of RoboTasks, the pour was demonstrated by
people's hands; else a simulated teacher demonstrates one like it.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.models import ProMP
from leadthrough.motion import Demonstration, PoseTrajectory, Trajectory
from leadthrough.motion_planning import Query, plan_motion
from leadthrough.preprocess.resample import by_arc_length
from leadthrough.shapes import Box, Cylinder, Scene
from leadthrough.shapes.scene import PLANNING_TOLERANCE
from leadthrough.timing import check_limits, keep_timing
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough_studies.demo.performed import Performed
from leadthrough_studies.demonstrator import Teaching, guide
from leadthrough_studies.robotasks.study import read

RECORDINGS = Path("robotasks", "pouring.npy")
# The simulated teacher: where the tool goes, m; how it holds the jug, and by how far it tips it.
_WAY = ((0.39, 0.11, 0.34), (0.41, -0.15, 0.38), (0.36, -0.41, 0.26))
_TEACHING = Teaching(duration=8.0, spread=0.012, bow=0.02, tremor=3e-4)
_REPETITIONS = 6
_UPRIGHT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
_TIPPED = 1.9  # rad
_TIPPED_BY_CHANCE = 0.05  # rad, standard deviation
_TIPPING = 0.4  # fraction of the time after which it begins

_ALONG_X = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
_JUG = Cylinder(0.035, 0.14, (0.0, 0.0, 0.0), _ALONG_X)  # in the tool's frame
_JUG_MASS = 0.4  # kg
_MOVED = np.array([0.06, -0.05, 0.0])  # m, of the glass
_GLASS = (0.035, 0.10)  # m, radius and height
_BEFORE_THE_GLASS = np.array([0.0, -0.10])  # m, from its middle to the tool
_BOTTLE = (0.035, 0.36)
_TABLE = Box((1.2, 1.6, 0.04), (0.35, -0.1, -0.02))
_MARGIN = 0.01  # m
_RATE = 250.0  # Hz


def run(seed: int = 0) -> Performed:
    """The scene, from demonstrations to joints.

    Args:
        seed: of the simulated teacher.
    """
    arm = Arm.load("panda").with_attached(_JUG, mass=_JUG_MASS)
    shown, by_whom = demonstrations(seed)
    skill = ProMP(weights=20).fit(shown)
    usual = skill.generate()
    end = usual.positions[-1] + _MOVED
    halfway = by_arc_length(usual.positions, 101)[50]
    around = (_TABLE, _standing(_GLASS, end[:2] + _BEFORE_THE_GLASS), _standing(_BOTTLE, halfway))
    scene = Scene(around, _MARGIN - PLANNING_TOLERANCE)  # planning keeps the rest besides
    goal = end, usual.orientations[-1]
    planned = plan_motion(skill, arm, scene, Query(goal=goal))
    path = planned.joints
    joints = keep_timing(path, arm.limits, rate=_RATE, path_tolerance=1e-3)
    return Performed(
        name="Pouring",
        told="A Panda carries a jug to a glass and tips it, at the pace that was shown.",
        model="ProMP",
        learned_from=f"{len(shown)} demonstrations by {by_whom}",
        asked="the glass 8 cm away, a bottle in the way",
        arm=arm,
        demonstrations=tuple(shown),
        joints=joints,
        limits=check_limits(joints, arm.limits),
        clearance=arm.check(joints, Scene(around, margin=0.0)),
        obstacles=around[1:],  # the scene's floor is the table
        goal=end,
        skill=skill,
    )


def demonstrations(seed: int) -> tuple[list[Demonstration[PoseTrajectory]], str]:
    """The demonstrations, and whose they are.

    Args:
        seed: of the simulated teacher.
    """
    recorded = Path(os.environ.get("LEADTHROUGH_DATA", "")) / RECORDINGS
    if recorded.is_file():
        return read(str(recorded)), "people's hands (RoboTasks)"
    rng = np.random.default_rng(seed)
    return [_shown(rng, number) for number in range(1, _REPETITIONS + 1)], "a simulated teacher"


def _shown(rng: np.random.Generator, number: int) -> Demonstration[PoseTrajectory]:
    """One pour of the simulated teacher."""
    carried = guide(np.array(_WAY), _TEACHING, rng).motion
    assert isinstance(carried, Trajectory)
    phases = carried.times / carried.times[-1]
    passed = minimum_jerk_time_scaling(np.clip((phases - _TIPPING) / (1.0 - _TIPPING), 0.0, 1.0))
    tipped = np.outer(passed, [rng.normal(_TIPPED, _TIPPED_BY_CHANCE), 0.0, 0.0])
    upright = np.repeat(rotations.from_matrix(_UPRIGHT[None]), len(phases), axis=0)
    turned = rotations.compose(rotations.exp(tipped), upright)
    poses = PoseTrajectory(carried.times, carried.positions, turned)
    return Demonstration(poses, name=f"pour {number}")


def _standing(size: tuple[float, float], at: Float64Array) -> Cylinder:
    """A cylinder of a radius and a height, m, that stands on the table."""
    radius, height = size
    return Cylinder(radius, height, (at[0], at[1], 0.5 * height))
