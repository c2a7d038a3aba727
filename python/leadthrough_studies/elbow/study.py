"""Random obstacles in the volume that the arm sweeps, at least 5 cm off the tip's path.

`Arm.follow` with these obstacles keeps the tip on its path and moves the rest of the arm around. A
scene that it does not solve is looked at more closely: at every fourth sample, inverse kinematics
from 600 random configurations says whether the arm can stand clear there at all. Where it cannot at
one of them, no search could succeed ("impossible").
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Literal

import numpy as np

from leadthrough.arm import Arm
from leadthrough.errors import IkFailure
from leadthrough_studies.elbow.report import report
from leadthrough_studies.elbow.scenes import FREE, Scene, scene
from leadthrough_studies.study import Row, Study, Task

MARGIN = 0.005  # m
_TRIES, _EVERY = 600, 4


@dataclass(frozen=True)
class ElbowConfig:
    """The configuration of the study.

    Attributes:
        arms: names of arms.
        scenes: of each arm.
        seed: of the scenes.
    """

    arms: tuple[str, ...] = ("panda", "ur3")
    scenes: int = 250
    seed: int = 0


def configure(quick: bool, seed: int) -> ElbowConfig:
    """The full configuration, or ten scenes of each arm."""
    return ElbowConfig(scenes=10, seed=seed) if quick else ElbowConfig(seed=seed)


def tasks(config: ElbowConfig) -> list[Task]:
    """A task for every scene."""
    return [
        Task(trap, {"arm": arm, "seed": config.seed, "index": i})
        for arm in config.arms
        for i in range(config.scenes)
    ]


def trap(*, arm: str, seed: int, index: int) -> list[Row]:
    """One row: a scene, whether the arm touches without looking, and what it does if it looks."""
    body = Arm.load(arm)
    made = scene(body, arm, np.random.default_rng([seed, index]))
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
        "arm": arm,
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
