"""Plans anew whenever a goal, an obstacle or a parameter is moved; knows nothing of windows."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure, InvalidInput, LeadthroughError
from leadthrough.models.parameters import Parameter
from leadthrough.models.protocol import Conditioned, Generator, Previewed, Skill
from leadthrough.motion import Demonstration, JointTrajectory, Motion, PoseTrajectory, Trajectory
from leadthrough.shapes import Shape, Sphere, check_shapes
from leadthrough.show.scene import tip_path

# Sampling of a preview and of a plan, s.
_PREVIEW_STEP = 0.04
_STEP = 0.01


@dataclass(frozen=True, eq=False)
class Answer:
    """A motion that was planned, or why there is none.

    path: (n, 3) m of the tip, None where there is none. joints: None where the arm cannot follow
    it. trouble: one line, empty where all went well. verdict: what a check of the whole arm says,
    empty for a preview. seconds: how long it took.
    """

    path: Float64Array | None
    joints: JointTrajectory | None
    trouble: str
    verdict: str
    seconds: float


class Replanner:
    """A skill that is asked again and again for an arm among obstacles.

    goal: (3,) m or (position (3,), orientation (4,)), by default the skill's own; None for skills
    that honour none. obstacles: in the arm's base frame; a skill that plans around none is only
    checked against them. demonstrations: those of the skill, for parameters that need another fit.
    `preview` answers while something is dragged, `plan` when it has come to rest.
    Raises InvalidInput for skills of motions that the arm cannot follow.
    """

    def __init__(
        self,
        arm: Arm,
        skill: Skill,
        *,
        goal: Any = None,
        obstacles: Iterable[Shape] = (),
        demonstrations: Sequence[Demonstration] = (),
    ) -> None:
        self.arm = arm
        self.obstacles = list(check_shapes(obstacles))
        self._demonstrations = tuple(demonstrations)
        self.skill: Skill = skill
        self.duration: float | None = None
        usual = skill.generate(dt=_STEP)
        if not isinstance(usual, JointTrajectory) and usual.positions.shape[1] != 3:
            raise InvalidInput("skill: expected one of points or poses in space, or of joints")
        self.usual_duration = float(usual.duration)
        self._first: Float64Array | None = None
        self._start = usual.positions[0]
        self._is_of_joints = isinstance(usual, JointTrajectory)
        self._is_of_poses = isinstance(usual, PoseTrajectory)
        self.goal_position, self.goal_orientation = self._usual_goal(usual)
        self._asked = False
        if goal is not None:
            self.move_goal(*(goal if isinstance(goal, tuple) and len(goal) == 2 else (goal,)))

    @property
    def has_goal(self) -> bool:
        """Whether the skill honours a goal where its motion ends; what goes round has none."""
        return "goal" in self.skill.supports and not self.skill.kind.startswith("rhythmic")

    @property
    def parameters(self) -> list[Parameter]:
        """What sliders may change about the skill as it is now."""
        return list(self.skill.parameters(self._demonstrations))

    def move_goal(self, position: Any, orientation: Any = None) -> None:
        """Another goal: (3,) m and, where not as before, (4,) w, x, y, z. Raises InvalidInput."""
        self.goal_position = check.array(position, "goal", shape=(3,)).copy()
        if orientation is not None:
            self.goal_orientation = check.quaternions(orientation, "goal", shape=(4,))
        self._asked = True

    def move_obstacle(self, index: int, position: Any, orientation: Any = None) -> None:
        """One obstacle's new pose. Raises InvalidInput."""
        count = len(self.obstacles)
        i = check.integer(index, "index", at_least=0, at_most=count - 1)
        shape = replace(self.obstacles[i], position=position)
        if orientation is not None and not isinstance(shape, Sphere):
            shape = replace(shape, orientation=orientation)
        self.obstacles[i] = shape

    def set_parameter(self, index: int, value: float) -> None:
        """Another value of `parameters[index]`. Raises InvalidInput, FitError."""
        self.skill = self.parameters[index].apply(value)
        self.__dict__.pop("_quick", None)  # it answers with the old value

    def asked_skill(self) -> Skill:
        """The skill, conditioned on the goal where it can be: its spread ends there.

        Raises InvalidInput for a goal of joints out of reach.
        """
        if self.has_goal and self._asked and isinstance(self.skill, Conditioned):
            return self.skill.condition(self.skill.duration, self._goal())
        return self.skill

    def preview(self) -> Answer:
        """An answer in less than a tenth of a second, coarser where it has to be."""
        return self._answer(_PREVIEW_STEP, preview=True)

    def plan(self) -> Answer:
        """The skill's own answer, and what a check of the whole arm says."""
        return self._answer(_STEP, preview=False)

    def _answer(self, dt: float, *, preview: bool) -> Answer:
        begin = time.perf_counter()
        path, joints, trouble, verdict = None, None, "", ""
        try:
            motion = self._motion(dt, preview=preview)
            path = tip_path(self.arm, motion)
            joints = self._followed(motion)
            if not preview:
                verdict = str(self.arm.check(joints, self.obstacles))
        except LeadthroughError as error:
            trouble = str(error)
        return Answer(path, joints, trouble, verdict, time.perf_counter() - begin)

    def _motion(self, dt: float, *, preview: bool) -> Motion:
        query: dict[str, Any] = {"dt": dt}
        if self.duration is not None:
            query["duration"] = self.duration
        if self.has_goal and self._asked:
            query["goal"] = self._goal()
        if "obstacles" in self.skill.supports:
            query["obstacles"] = tuple(self.obstacles)
        return (self._quick if preview else self.skill).generate(**query)

    def _followed(self, motion: Trajectory | PoseTrajectory | JointTrajectory) -> JointTrajectory:
        if isinstance(motion, JointTrajectory):
            return motion
        joints = self._from_the_same_posture(motion)
        self._first = joints.positions[0]
        return joints

    def _from_the_same_posture(self, motion: Trajectory | PoseTrajectory) -> JointTrajectory:
        """As before where that goes: an arm that jumps while one drags is hard to look at."""
        if self._first is not None:
            try:
                return self.arm.follow(motion, seed=self._first)
            except IkFailure:
                pass
        return self.arm.follow(motion)

    def _usual_goal(self, usual: Motion) -> tuple[Float64Array, Float64Array | None]:
        if self._is_of_joints:
            self._last_joints = usual.positions[-1]
            return self.arm.forward_kinematics(usual.positions[-1])
        turned = usual.orientations[-1] if isinstance(usual, PoseTrajectory) else None
        return usual.positions[-1].copy(), turned

    def _goal(self) -> Any:
        """The goal as the skill wants it. Raises InvalidInput for joints out of reach."""
        if self._is_of_poses:
            return self.goal_position, self.goal_orientation
        if not self._is_of_joints:
            return self.goal_position
        found = self.arm.inverse_kinematics(
            self.goal_position, self.goal_orientation, seed=self._last_joints
        )
        if not found.success:
            raise InvalidInput(f"goal: the arm does not reach it ({found.status})")
        return found.q

    @cached_property
    def _quick(self) -> Generator:
        return self.skill.preview() if isinstance(self.skill, Previewed) else self.skill
