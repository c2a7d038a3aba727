"""The motions besides the handwriting: courses of points in space and motions of poses, in m and s.

- Courses: a symbol that a person traced six times with a Panda (panda_symbol; its pauses, which
  differ, are cut short), and the reaches of the ur3 study, in an empty workspace and over a box.
- Poses: the recordings of RoboTasks, and a Panda's reach by a simulated person, of the human study.
- Joints: those of the same reach.

Recordings are taken from the folder that LEADTHROUGH_DATA names; without it they are left out.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, cast

import numpy as np

import leadthrough as lt
from leadthrough import rotations
from leadthrough.motion import Demonstration, Motion, PoseTrajectory, Trajectory
from leadthrough.preprocess import clean
from leadthrough_studies.demonstrator import Teaching
from leadthrough_studies.human import demonstrations as reach
from leadthrough_studies.robotasks.study import read
from leadthrough_studies.ur3 import setups

_SYMBOL_RATE = 1000.0  # Hz
_KEPT_RATE = 50.0  # Hz
_PAUSE = 0.1  # s; longer ones are cut
_PERSONS = 6
_REACHES = {"reach beside a table": 1, "reach over a box": 2}
_BY_HAND = "reach by hand"
MOTIONS_OF_JOINTS = (_BY_HAND + ", joints",)


def courses() -> dict[str, Path | None]:
    """Names of all courses, with the recording of those that are recorded."""
    return {**{file.stem: file for file in _recorded("panda_symbol/*.mat")}, **_simulated(_REACHES)}


def motions_of_poses() -> dict[str, Path | None]:
    """Names of all motions of poses, with the recording of those that are recorded."""
    return {**{file.stem: file for file in _recorded("robotasks/*.npy")}, **_simulated([_BY_HAND])}


def course(name: str, file: Path | None, seed: int) -> list[Demonstration[Trajectory]]:
    """The demonstrations of a course.

    Args:
        name: its name.
        file: its recording; None for a simulated one.
        seed: seed of the random number generator, for a simulated one.
    """
    if file is None:
        return setups.demonstrations(_REACHES[name], Teaching(), seed)
    recorded = lt.read_demonstrations([file], rate=_SYMBOL_RATE, rest=math.inf)
    cut = [clean(each, longest_pause=_PAUSE, rate=_KEPT_RATE)[0] for each in recorded]
    return cast(list[Demonstration[Trajectory]], cut)


def poses(name: str, file: Path | None, seed: int) -> list[Demonstration[PoseTrajectory]]:
    """The demonstrations of a motion of poses.

    Args:
        name: its name.
        file: its recording; None for a simulated one.
        seed: seed of the random number generator, for a simulated one.
    """
    if file is not None:
        return read(str(file))
    arm = lt.Arm.load(reach.ROBOT)
    return [Demonstration(_of_tool(arm, each.motion), name) for each in joints(seed)]


def joints(seed: int) -> list[Demonstration[Any]]:
    """The demonstrations of the reach by hand, in joints.

    Args:
        seed: seed of the random number generator.
    """
    return reach.human(_PERSONS, np.random.default_rng(seed))


def _of_tool(arm: lt.Arm, motion: Motion) -> PoseTrajectory:
    positions, orientations = arm.forward_kinematics(motion.positions)
    return PoseTrajectory(motion.times, positions, rotations.align_signs(orientations))


def _recorded(pattern: str) -> list[Path]:
    folder = os.environ.get("LEADTHROUGH_DATA", "")
    return sorted(Path(folder).glob(pattern)) if folder else []


def _simulated(names: Iterable[str]) -> dict[str, Path | None]:
    return dict.fromkeys(names)
