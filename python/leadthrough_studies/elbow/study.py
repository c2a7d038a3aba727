"""Random obstacles in the volume that the arm sweeps, at least 5 cm off the tip's path.

`Arm.follow` with these obstacles keeps the tip on its path and moves the rest of the arm around.
The first scenes of each kind are also given to a slow search (`reference`) and, where OMPL is
installed, to its RRT-Connect, which knows the ends of the path only. A scene that `follow` does not
solve is looked at more closely: at every fourth sample, inverse kinematics from 600 random
configurations says whether the arm can stand clear there at all. Where it cannot at one of them, no
search could succeed ("impossible").
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import numpy as np

from leadthrough.arm import Arm
from leadthrough.errors import IkFailure
from leadthrough_studies.elbow.peers import connected, searched
from leadthrough_studies.elbow.report import report
from leadthrough_studies.elbow.scenes import FREE, MARGIN, Scene, drawn_scene
from leadthrough_studies.study import Row, Study, Task

_TRIES, _EVERY = 600, 4
_FOLDER = "robotasks"


@dataclass(frozen=True)
class ElbowConfig:
    """The configuration of the study.

    Attributes:
        arms: names of arms.
        scenes: of each kind: reaches of each arm, and demonstrations of RoboTasks with the Panda.
        compared: how many of each kind are given to the slow search and to RRT-Connect.
        files: demonstrations of RoboTasks; without any, there are only reaches.
        seed: of the scenes.
    """

    arms: tuple[str, ...] = ("panda", "ur3")
    scenes: int = 170
    compared: int = 60
    files: tuple[str, ...] = ()
    seed: int = 0


def configure(quick: bool, seed: int) -> ElbowConfig:
    """The full configuration with the recordings in LEADTHROUGH_DATA, or ten scenes of each kind.

    The quick one compares with nothing.
    """
    folder = Path(os.environ.get("LEADTHROUGH_DATA", "")) / _FOLDER
    files = tuple(str(file) for file in sorted(folder.glob("*.npy")))
    if quick:
        return ElbowConfig(scenes=10, compared=0, files=files, seed=seed)
    return ElbowConfig(files=files, seed=seed)


def tasks(config: ElbowConfig) -> list[Task]:
    """A task for every scene and everyone who is given it."""
    made = [
        Task(trap, {**kind, "seed": config.seed, "index": i})
        for kind in _kinds(config)
        for i in range(config.scenes)
    ]
    peers = [searched, connected] if find_spec("ompl") else [searched]
    return made + [
        Task(peer, {**kind, "seed": config.seed, "index": i})
        for peer in peers
        for kind in _kinds(config)
        for i in range(min(config.compared, config.scenes))
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
        joints = body.follow(
            made.tip, seed=made.joints.positions[0], free=FREE[arm], obstacles=made.obstacles
        )
        failure = None
    except IkFailure as error:
        failure = str(error)
    row = {
        "by": "follow",
        "arm": arm,
        "motion": motion,
        "index": index,
        "obstacles": len(made.obstacles),
        "touches_without": int(not body.check(made.joints, made.obstacles).ok),
        "solved": int(failure is None),
        "follow_cpu_s": time.process_time() - begin,
        "failure": failure,
        "impossible": 0,
    }
    if failure is None:
        checked = body.check(joints, made.obstacles, margin=MARGIN)
        row["clear"] = int(checked.ok)
        row["distance_m"] = checked.obstacles.minimum_distance
        row["tip_error_m"] = float(body.path_report(joints, made.tip).position_error.max())
        row["largest_step_rad"] = float(np.abs(np.diff(joints.positions, axis=0)).max())
    else:
        row |= {"clear": 0, "distance_m": None, "tip_error_m": None, "largest_step_rad": None}
        row["impossible"] = int(_impossible(body, made, FREE[arm]))
    return [row]


def _impossible(arm: Arm, made: Scene, free: tuple[Literal["rz"], ...]) -> bool:
    """Whether the arm cannot stand clear at one of the samples."""
    rng = np.random.default_rng(0)
    low, high = (np.clip(ends, -np.pi, np.pi) for ends in (arm.limits.lower, arm.limits.upper))
    seeds = rng.uniform(low, high, (_TRIES, len(arm.joint_names)))
    for i in range(0, len(made.tip), _EVERY):
        near = np.vstack([made.joints.positions[i], seeds])
        found = arm.inverse_kinematics_batch(
            np.tile(made.tip.positions[i], (len(near), 1)),
            np.tile(made.tip.orientations[i], (len(near), 1)),
            seeds=near,
            free=free,
            position_tolerance=1e-5,
            orientation_tolerance=1e-5,
            max_restarts=0,
        )
        q = found.q[found.success]
        if not np.any(arm.is_clear(q, made.obstacles, margin=MARGIN)):
            return True
    return False


STUDY = Study(configure, tasks, report)
