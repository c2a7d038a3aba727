"""What a planner learns from a task as it was shown, looked up by subtask and target.

Source: Lauretti et al. 2023, section 2.1 (figure 1), for the look-up in a database.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.experiments.agriculture_tasks import TASKS, Subtask, postures, targets
from leadthrough.experiments.demonstrator import JointTeaching, guide_joints
from leadthrough.models import PoseDMP, SkillLibrary
from leadthrough.models.pose_dmp import PoseDMPSkill
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory

DURATION = 10.0  # s of a subtask, the paper's
STEP = 0.02  # s


@dataclass(frozen=True, eq=False)
class Shown:
    """A demonstration, as the encoders saw it and as the tool moved."""

    joints: JointTrajectory
    poses: PoseTrajectory


@dataclass(frozen=True, eq=False)
class Learned:
    """shown: by subtask and number of the target. refused: why the planner learned nothing."""

    task: str
    model: PoseDMP
    targets: Mapping[int, Float64Array]
    shown: Mapping[tuple[str, int], Shown]
    library: SkillLibrary
    refused: Mapping[tuple[str, int], str]

    def skill(self, subtask: Subtask, target: Float64Array) -> PoseDMPSkill:
        """The skill of the nearest target. Raises InvalidInput where there is none."""
        found = self.library.nearest(self.task, subtask.number, target)
        assert isinstance(found, PoseDMPSkill)
        return found

    def goal(self, subtask: Subtask, target: Float64Array) -> Float64Array:
        """Where the subtask ends for a target, (3,) m."""
        learned = self.skill(subtask, target).springs.ends.goal[:3]
        if not subtask.ends_at_target:
            return learned
        known = [at for i, at in self.targets.items() if (subtask.number, i) not in self.refused]
        nearest = min(known, key=lambda at: float(np.linalg.norm(at - target)))
        return np.asarray(learned + target - nearest)


def show(arm: Arm, task: str, subtask: Subtask, i: int, *, seed: int) -> Shown:
    """The simulated person's demonstration for a target; the same for every planner."""
    place = [list(TASKS).index(task), TASKS[task].index(subtask), i]
    stops = postures(arm, task, subtask, targets(task)[i])
    joints = guide_joints(stops, JointTeaching(), np.random.default_rng([seed, *place])).motion
    assert isinstance(joints, JointTrajectory)
    poses = PoseTrajectory(joints.times, *arm.forward_kinematics(joints.positions))
    return Shown(joints, poses)


def learn(arm: Arm, task: str, model: PoseDMP, repetitions: Sequence[int], *, seed: int) -> Learned:
    """All subtasks, for the targets given by number."""
    at = {i: targets(task)[i] for i in repetitions}
    library, refused, shown = SkillLibrary(), {}, {}
    for subtask in TASKS[task]:
        for i, target in at.items():
            key = subtask.number, i
            shown[key] = show(arm, task, subtask, i, seed=seed)
            try:
                skill = model.fit([Demonstration(shown[key].poses)])
            except FitError as error:
                refused[key] = str(error)
                continue
            library = library.with_skill(skill, task=task, subtask=subtask.number, target=target)
    return Learned(task, model, at, shown, library, refused)


def chain(learned: Learned, target: Float64Array) -> PoseTrajectory:
    """The whole task for a target, each subtask from where the last one ended.

    Raises UnsupportedQuery where a planner refuses, InvalidInput where it learned nothing.
    """
    parts: list[PoseTrajectory] = []
    for subtask in TASKS[learned.task]:
        start = (parts[-1].positions[-1], parts[-1].orientations[-1]) if parts else None
        skill, goal = learned.skill(subtask, target), learned.goal(subtask, target)
        parts.append(skill.generate(start=start, goal=goal, duration=DURATION, dt=STEP))
    # Each begins with the sample that the one before ends with.
    return PoseTrajectory(
        np.concatenate([[0.0], *(part.times[1:] + k * DURATION for k, part in enumerate(parts))]),
        np.concatenate([parts[0].positions[:1], *(part.positions[1:] for part in parts)]),
        np.concatenate([parts[0].orientations[:1], *(part.orientations[1:] for part in parts)]),
    )


def fastest_turn(motion: PoseTrajectory) -> float:
    """The largest angular speed between samples, degrees/s."""
    angles = rotations.distance(motion.orientations[1:], motion.orientations[:-1])
    return float(np.degrees((angles / np.diff(motion.times)).max()))
