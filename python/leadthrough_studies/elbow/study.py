"""Random obstacles in the volume that the arm sweeps, at least 5 cm off the tip's path.

`Arm.follow` with these obstacles keeps the tip on its path and moves the rest of the arm around.
A scene that it does not solve is looked at more closely: at every fourth sample, inverse kinematics
from 600 random configurations says whether the arm can stand clear there at all. If it cannot at
one of them, no search could succeed ("impossible"). The others that `follow` does not solve are
given to a slow search (`reference`) for at least a minute of processor time. If `follow` has a
solution, the scene counts as one that such a search solves as well.

Every solution is looked at again by coal, if that and Pinocchio are installed, in steps of 0.1 mm
along the spline that is executed. The first scenes of each kind are also given to
RRT-Connect, which knows the ends of the path only.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.errors import IkFailure
from leadthrough.shapes import Scene
from leadthrough_studies import coal_arm
from leadthrough_studies.elbow.peers import connected, impossible, searched
from leadthrough_studies.elbow.recheck import rechecked
from leadthrough_studies.elbow.report import report
from leadthrough_studies.elbow.scenes import MARGIN, drawn_scene, followed
from leadthrough_studies.study import Row, Study, Task

_FOLDER = "robotasks"


@dataclass(frozen=True)
class ElbowConfig:
    """The configuration of the study.

    Attributes:
        arms: names of arms.
        scenes: of each kind: reaches of each arm, and demonstrations of RoboTasks with the Panda.
        searched: whether what `follow` does not solve is given to the slow search.
        connected: whether they are given to RRT-Connect too.
        files: demonstrations of RoboTasks; without any, there are only reaches.
        seed: of the scenes.
    """

    arms: tuple[str, ...] = ("panda", "ur3")
    scenes: int = 170
    searched: bool = True
    connected: bool = True
    files: tuple[str, ...] = ()
    seed: int = 0


def configure(quick: bool, seed: int) -> ElbowConfig:
    """The full configuration with the recordings in LEADTHROUGH_DATA, or ten scenes of each kind.

    The quick one asks neither the slow search nor RRT-Connect.
    """
    folder = Path(os.environ.get("LEADTHROUGH_DATA", "")) / _FOLDER
    files = tuple(str(file) for file in sorted(folder.glob("*.npy")))
    if quick:
        return ElbowConfig(scenes=10, searched=False, connected=False, files=files, seed=seed)
    return ElbowConfig(files=files, seed=seed)


def tasks(config: ElbowConfig) -> list[Task]:
    """A task for every scene and everyone who is given it."""
    asked: list[tuple[Callable[..., list[Row]], int]] = [(trap, config.scenes)]
    if config.searched:
        asked.append((searched, config.scenes))
    if coal_arm.installed():
        asked.append((rechecked, config.scenes))
    if config.connected:
        asked.append((connected, config.scenes))
    return [
        Task(function, {**kind, "seed": config.seed, "index": i})
        for function, count in asked
        for kind in _kinds(config)
        for i in range(count)
    ]


def _kinds(config: ElbowConfig) -> list[dict[str, Any]]:
    kinds = [{"arm": arm, "motion": "reach", "files": []} for arm in config.arms]
    if config.files and "panda" in config.arms:
        kinds.append({"arm": "panda", "motion": "shown", "files": list(config.files)})
    return kinds


def trap(*, arm: str, motion: str, seed: int, index: int, files: list[str]) -> list[Row]:
    """One row: a scene, whether the arm touches without looking, and what it does if it looks."""
    body = Arm.load(arm)
    made = drawn_scene(body, arm, seed, index, files)
    body.is_clear(made.joints.positions[0])  # the shapes are made ready outside the measured time
    begin = time.process_time()
    try:
        joints = followed(body, arm, made)
        failure = None
    except IkFailure as error:
        failure = str(error)
    row = {
        "by": "follow",
        "arm": arm,
        "motion": motion,
        "index": index,
        "obstacles": len(made.obstacles),
        "touches_without": int(not body.check(made.joints, Scene(made.obstacles, margin=0.0)).ok),
        "solved": int(failure is None),
        "follow_cpu_s": time.process_time() - begin,
        "failure": failure,
        "impossible": 0,
    }
    if failure is None:
        checked = body.check(joints, Scene(made.obstacles, MARGIN))
        row["clear"] = int(checked.ok)
        row["distance_m"] = checked.obstacles.minimum_distance
        row["tip_error_m"] = float(body.path_report(joints, made.tip).position_error.max())
        row["largest_step_rad"] = float(np.abs(np.diff(joints.positions, axis=0)).max())
    else:
        row |= {"clear": 0, "distance_m": None, "tip_error_m": None, "largest_step_rad": None}
        row["impossible"] = int(impossible(body, arm, made))
    return [row]


STUDY = Study(configure, tasks, report)
