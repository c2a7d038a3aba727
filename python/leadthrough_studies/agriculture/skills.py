"""The skills that a planner learns from the demonstrations of a task, by subtask and target.

Source: Lauretti et al. 2023, section 2.1 (figure 1), for the look-up in a database. Besides the
motions of the tool, the library holds the motions of the joints, which give a redundant arm the
postures for following the tool.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models import DMP, DMPSkill, SkillLibrary
from leadthrough.motion import Demonstration, Event, JointTrajectory, PoseTrajectory
from leadthrough.preprocess import join
from leadthrough_studies.agriculture.tasks import CHOSEN, TASKS, Holding, Subtask, postures, targets
from leadthrough_studies.demonstrator import JointTeaching, guide_joints

DURATION = 10.0  # s per subtask, as in the paper
STEP = 0.02  # s
PLANNED_STEP = 0.01  # s, step of the motions whose planning is timed: 1000 steps
LOOKUPS = ("nearest", "interpolated")


@dataclass(frozen=True, eq=False)
class Shown:
    """A motion of the joints and of the tool; both have the gripper's events."""

    joints: JointTrajectory
    poses: PoseTrajectory


@dataclass(frozen=True, eq=False)
class Learned:
    """The skills for one task.

    Attributes:
        task: name of the task.
        model: the planner.
        targets: positions (3,) of the targets by number, m.
        shown: demonstrations by number of subtask and of target.
        library: the skills of the tool and of the joints.
        refused: error messages by number of subtask and of target where the planner failed to
          learn.
    """

    task: str
    model: DMP
    targets: Mapping[int, Float64Array]
    shown: Mapping[tuple[str, int], Shown]
    library: SkillLibrary
    refused: Mapping[tuple[str, int], str]

    def skill(
        self, subtask: Subtask, target: Float64Array, *, lookup: str = "nearest"
    ) -> DMPSkill[PoseTrajectory]:
        """The skill of the tool for a target.

        Args:
            subtask: the subtask.
            target: position (3,), m.
            lookup: one of LOOKUPS.

        Raises:
            InvalidInput: if the library has no skill of the subtask.
            FitError: if no skill can be interpolated between the neighbours.
        """
        found: DMPSkill[PoseTrajectory] = getattr(self.library, lookup)(
            self.task, subtask.number, target
        )
        return found

    def posture(self, subtask: Subtask, target: Float64Array, *, lookup: str = "nearest") -> Any:
        """The skill of the joints for a target, looked up like `skill`."""
        return getattr(self.library, lookup)(_joints_of(self.task), subtask.number, target)

    def goal(
        self, subtask: Subtask, target: Float64Array, *, lookup: str = "nearest"
    ) -> Float64Array:
        """The end (3,) of the subtask for a target, m: that of the nearest target, shifted."""
        learned = self.skill(subtask, target, lookup=lookup).system.ends.goal[:3]
        if not subtask.ends_at_target or lookup == "interpolated":
            return learned
        known = [at for i, at in self.targets.items() if (subtask.number, i) not in self.refused]
        nearest = min(known, key=lambda at: float(np.linalg.norm(at - target)))
        return np.asarray(learned + target - nearest)


def show(
    arm: Arm,
    task: str,
    subtask: Subtask,
    i: int,
    *,
    seed: int,
    target: Float64Array | None = None,
    holding: Holding = CHOSEN,
) -> Shown:
    """The simulated person's demonstration of a subtask; the same for every planner.

    Args:
        arm: the TIAGo.
        task: name of the task.
        subtask: the subtask.
        i: number of the target.
        seed: seed of the simulated person.
        target: another position (3,), m, instead of the one of target i.
        holding: how the person holds the arm.
    """
    place = [list(TASKS).index(task), TASKS[task].index(subtask), i]
    at = targets(task)[i] if target is None else target
    stops = postures(arm, task, subtask, at, holding)
    joints = guide_joints(stops, JointTeaching(), np.random.default_rng([seed, *place])).motion
    assert isinstance(joints, JointTrajectory)
    if subtask.gripper:
        joints = replace(joints, events=(Event(float(joints.times[-1]), subtask.gripper),))
    tool = arm.forward_kinematics(joints.positions)
    return Shown(joints, PoseTrajectory(joints.times, *tool, joints.events))


def learn(arm: Arm, task: str, model: DMP, repetitions: Sequence[int], *, seed: int) -> Learned:
    """The skills of all subtasks of a task, for targets given by number."""
    at = {i: targets(task)[i] for i in repetitions}
    library, refused, shown = SkillLibrary(), {}, {}
    for subtask in TASKS[task]:
        for i, target in at.items():
            key = subtask.number, i
            shown[key] = show(arm, task, subtask, i, seed=seed)
            place = {"subtask": subtask.number, "target": target}
            stood = DMP().fit([Demonstration(shown[key].joints)])
            library = library.with_skill(stood, task=_joints_of(task), **place)
            try:
                skill = model.fit([Demonstration(shown[key].poses)])
            except FitError as error:
                refused[key] = str(error)
                continue
            library = library.with_skill(skill, task=task, **place)
    return Learned(task, model, at, shown, library, refused)


def chain(learned: Learned, target: Float64Array, *, lookup: str = "nearest") -> Shown:
    """The whole task for a target; each subtask starts where the previous one ended.

    Args:
        learned: the skills of the task.
        target: position (3,), m.
        lookup: one of LOOKUPS.

    Raises:
        UnsupportedQuery: if the planner refuses a query.
        FitError: if no skill can be interpolated.
        InvalidInput: if a skill is missing.
    """
    poses: list[PoseTrajectory] = []
    stands: list[JointTrajectory] = []
    for subtask in TASKS[learned.task]:
        skill = learned.skill(subtask, target, lookup=lookup)
        goal = learned.goal(subtask, target, lookup=lookup)
        start = (poses[-1].positions[-1], poses[-1].orientations[-1]) if poses else None
        poses.append(skill.generate(start=start, goal=goal, duration=DURATION, dt=STEP))
        posture = learned.posture(subtask, target, lookup=lookup)
        stood = stands[-1].positions[-1] if stands else None
        stands.append(posture.generate(start=stood, duration=DURATION, dt=STEP))
    tool, joints = join(poses), join(stands)
    assert isinstance(tool, PoseTrajectory)
    assert isinstance(joints, JointTrajectory)
    return Shown(joints, tool)


def fastest_turn(motion: PoseTrajectory) -> float:
    """The largest angular speed between samples, degrees/s."""
    angles = rotations.distance(motion.orientations[1:], motion.orientations[:-1])
    return float(np.degrees((angles / np.diff(motion.times)).max()))


def _joints_of(task: str) -> str:
    """The library's name for the joint motions of a task."""
    return f"{task}, joints"
