"""A lesson on a live page: recorded demonstrations, each in a file of its own, the skill of them,
and the command that goes on from there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.io.formats import write_motion
from leadthrough.models.learn import learn, reproduction
from leadthrough.motion import Demonstration, Event, JointTrajectory, PoseTrajectory
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Scene
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.show.replanner import Replanner

_STILL = 1e-4  # rad or m; joints that differ by less at a recording's ends rest
_MIN_SAMPLES = 10
_MIN_PATH, _MIN_TURN = 0.01, 0.1  # m and rad, of the tip in a demonstration
_NAME = "demonstration-{}"


class Recordings:
    """Joint motions of an arm, in a folder."""

    def __init__(self, arm: Arm, folder: Path, demonstrations: Sequence[Any]) -> None:
        self.arm, self.folder = arm, folder
        self.demonstrations = [_of_arm(arm, each, i) for i, each in enumerate(demonstrations)]

    def add(self, motion: JointTrajectory) -> Path:
        """Writes a motion to a new file, whose path is returned."""
        name = self._free_name()
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{name}.csv"
        write_motion(motion, path)
        self.demonstrations.append(Demonstration(motion, name))
        return path

    def remove(self, index: int) -> str:
        """Deletes a demonstration and its file; its name."""
        gone = self.demonstrations.pop(index)
        (self.folder / f"{gone.name}.csv").unlink(missing_ok=True)
        return gone.name

    def motion(self, index: object) -> JointTrajectory:
        """The motion at an index of any type."""
        return self.demonstrations[self.checked(index)].motion

    def checked(self, index: object) -> int:
        """The index, if there is a demonstration at it."""
        last = len(self.demonstrations) - 1
        return check.integer(-1 if index is None else index, "index", at_least=0, at_most=last)

    def listed(self) -> list[dict[str, Any]]:
        """Name, duration and length of the tip's path of each demonstration."""
        return [
            {
                "name": each.name,
                "seconds": round(float(each.motion.duration), 2),
                "metres": round(self._length(each.motion), 3),
            }
            for each in self.demonstrations
        ]

    def _length(self, motion: JointTrajectory) -> float:
        return float(arc_length(self.arm.forward_kinematics(motion.positions)[0])[-1])

    def _free_name(self) -> str:
        taken = {each.name for each in self.demonstrations}
        taken |= {path.stem for path in self.folder.glob("*.csv")}
        numbers = (int(found[1]) for name in taken if (found := re.fullmatch(r".*-(\d+)", name)))
        return _NAME.format(max(numbers, default=0) + 1)


def _of_arm(arm: Arm, given: object, index: int) -> Demonstration[JointTrajectory]:
    """A demonstration with the arm's joints in its order."""
    if not isinstance(given, Demonstration):
        raise check.refused(f"demonstrations[{index}]", "a Demonstration", type(given).__name__)
    return Demonstration(arm.joints_of(given.motion), given.name)


def recording_of(
    arm: Arm, samples: Sequence[tuple[float, Float64Array]], events: Sequence[Event]
) -> JointTrajectory | None:
    """The motion in a recording, without rest at its ends; None if the tip did not move."""
    times = np.array([time for time, _ in samples])
    q = np.array([each for _, each in samples])
    moved = np.flatnonzero(
        (np.abs(q - q[0]).max(axis=1) > _STILL) & (np.abs(q - q[-1]).max(axis=1) > _STILL)
    )
    if len(moved) < _MIN_SAMPLES:
        return None
    first, last = max(moved[0] - 1, 0), min(moved[-1] + 1, len(q) - 1)
    kept = slice(first, last + 1)
    motion = JointTrajectory(
        times[kept] - times[first],
        q[kept],
        joint_names=arm.joint_names,
        events=[
            Event(float(np.clip(each.time, times[first], times[last]) - times[first]), each.name)
            for each in events
        ],
    )
    poses = arm.poses(motion)
    turned = math.dist(poses.orientations[0], poses.orientations[-1]) > 0.5 * _MIN_TURN
    return motion if arc_length(poses.positions)[-1] > _MIN_PATH or turned else None


@dataclass(frozen=True, eq=False)
class Learned:
    """A skill of the demonstrations, and how near it comes to them."""

    planner: Replanner
    text: str


def learned(arm: Arm, demonstrations: Sequence[Demonstration[Any]], scene: Scene) -> Learned:
    """The skill of joint motions, as poses of the tip."""
    poses: list[Demonstration[PoseTrajectory]] = [
        Demonstration(arm.poses(each.motion), each.name) for each in demonstrations
    ]
    skill = learn(poses)
    near = reproduction(skill, poses)
    family = type(skill.model).__name__
    text = f"Learned by {family}, within {1e3 * near.position:.2g} mm of every demonstration."
    return Learned(Replanner(arm, skill, scene=scene, demonstrations=poses), text)


def plan_command(planner: Replanner, skill_path: Path, scene: Scene) -> str:
    """The command that plans with a saved skill as the page does now."""
    words = ["leadthrough plan", str(skill_path)]
    if planner.has_moved_goal:
        goal = [planner.goal_position, planner.goal_orientation]
        texts = [numbers(np.asarray(part)) for part in goal if part is not None]
        words.append(f"--goal={'/'.join(texts)}")
    return " ".join([*words, *obstacle_words(scene), "-o", "motion.json"])


def obstacle_words(scene: Scene) -> list[str]:
    """The solids of a scene as options of the command line; meshes and clouds are left out."""
    texts = map(_written, scene.shapes)
    return [f"--obstacle {text}" for text in texts if text]


def _written(shape: Any) -> str:  # Any: only solids have sizes
    """A solid as the command line has it; empty for meshes and clouds."""
    kind = next((name for name, each in PRIMITIVES.items() if type(shape) is each), None)
    if kind is None:
        return ""
    parts = ((shape.sizes, "@"), (shape.position, "/"), (shape.orientation, ""))
    return f"{kind}:" + "".join(numbers(part) + end for part, end in parts)


def numbers(values: Float64Array) -> str:
    """Numbers as the command line has them, to 0.01 mm."""
    return ",".join(f"{x + 0.0:g}" for x in np.round(values, 5))
