"""A skill that plans anew whenever its goal, an obstacle or a parameter changes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, motion_planning, rotations
from leadthrough.arm import Arm, FollowOptions
from leadthrough.arm.following import follow
from leadthrough.arm.ik_failure import limiting_joints_text
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.check import Float64Array, IkFailure, InvalidInput, LeadthroughError, ShortRepr
from leadthrough.models.corrected import CorrectedSkill
from leadthrough.models.protocol import Conditioned, Generator, Parameter, Previewed, Skill
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Target,
    Trajectory,
    in_order,
)
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.show.arm_scene import tip_path

# Sampling of a preview and of a plan, s.
_PREVIEW_STEP = 0.04
_STEP = 0.01
# A detour around obstacles is searched at this distance first, m: it serves some more moves.
_AMPLE = 0.03
# How strongly a preview stays next to the answer before, 1/s: at any larger rate it is the same.
_PULL = 100.0


@dataclass(frozen=True, eq=False)
class Answer(ShortRepr):
    """A motion that was planned, or the reason why there is none."""

    path: Float64Array | None  # the tip's path (n, 3), m; None if there is none
    joints: JointTrajectory | None
    trouble: str  # the reason for a missing motion, in one line; empty if there is none
    verdict: str  # of a collision check of the whole arm; empty for a preview
    seconds: float  # of computation
    wanted: Float64Array | None = None  # the tip's path (m, 3) by the skill alone
    others: tuple[Float64Array, ...] = ()  # that path by the modes that are not taken


class End:
    """The start or the goal of a motion, of the tip; and the skill's own joints there, if any."""

    def __init__(self, arm: Arm, motion: Motion, name: str) -> None:
        self._arm, self._name = arm, name
        self._row = 0 if name == "start" else -1
        self.moved = False
        self._joints: Float64Array | None = None
        self.orientation: Float64Array | None = None
        self.position = motion.positions[self._row].copy()
        if isinstance(motion, JointTrajectory):
            self._joints = self.position
            self.position, self.orientation = arm.forward_kinematics(self._joints)
        elif isinstance(motion, PoseTrajectory):
            self.orientation = motion.orientations[self._row]

    def move(self, position: ArrayLike, orientation: ArrayLike | None = None) -> None:
        self.position = check.array(position, self._name, shape=(3,)).copy()
        if orientation is not None:
            self.orientation = check.quaternions(orientation, self._name, shape=(4,))
        self.moved = True

    def turn(self, vector: Float64Array) -> None:
        """Turns it by a rotation vector, where it has an orientation."""
        if self.orientation is not None:
            turn = rotations.exp(vector[None])
            self.move(self.position, rotations.compose(turn, self.orientation[None])[0])

    def target(self) -> Target | None:
        """The place in the form that the skill takes; None for its own."""
        if not self.moved:
            return None
        if self._joints is not None:
            return self._solved(self._joints)
        return self.position if self.orientation is None else (self.position, self.orientation)

    def _solved(self, near: Float64Array) -> Float64Array:
        found = self._arm.inverse_kinematics(self.position, self.orientation, q0=near)
        if not found.success:
            bars = [name in found.limiting_joints for name in self._arm.joint_names]
            why = limiting_joints_text(self._arm.limits, found.q, bars) or found.status
            raise InvalidInput(
                f"{self._name}: the arm does not reach it: {why}; the nearest is "
                f"{found.position_error:.3g} m and {found.orientation_error:.3g} rad away"
            )
        return found.q


class Replanner:
    """A skill that is asked again and again for a motion of an arm among obstacles."""

    def __init__(
        self,
        arm: Arm,
        skill: Skill,
        *,
        goal: Target | None = None,
        scene: SceneLike = (),
        demonstrations: Sequence[Demonstration] = (),
    ) -> None:
        self.arm = arm
        self._given = as_scene(scene)
        self.obstacles = list(self._given.shapes)
        self._demonstrations = tuple(demonstrations)
        self.skill: Skill = skill
        self.duration: float | None = None
        nominal = skill.generate(dt=_STEP)
        if not isinstance(nominal, JointTrajectory) and nominal.positions.shape[1] != 3:
            raise InvalidInput(
                "skill: expected one of points or poses in 3-D, or of joints, "
                f"got one of points in {nominal.positions.shape[1]}-D"
            )
        self.nominal_duration = float(nominal.duration)
        self._first: Float64Array | None = None
        self._last: JointTrajectory | None = None
        self._has_ample_room = True
        self._may_search = True
        self._is_of_joints = isinstance(nominal, JointTrajectory)
        self.start, self.goal = (End(arm, nominal, name) for name in ("start", "goal"))
        if goal is not None:
            self.goal.move(*parted(goal))

    @property
    def scene(self) -> Scene:
        """The obstacles where they were moved to, and the margins."""
        return replace(self._given, obstacles=tuple(self.obstacles))

    def end(self, name: Literal["start", "goal"]) -> End | None:
        """The start or the goal, if the skill honours it; a rhythm has neither."""
        if name not in self.skill.supports or self.skill.kind.startswith("rhythmic"):
            return None
        return self.start if name == "start" else self.goal

    @property
    def parameters(self) -> list[Parameter]:
        """The numbers of the present skill that sliders may change."""
        return list(self.skill.parameters(self._demonstrations))

    def move_obstacle(
        self, index: int, position: ArrayLike, orientation: ArrayLike | None = None
    ) -> None:
        """Moves one obstacle."""
        count = len(self.obstacles)
        i = check.integer(index, "index", at_least=0, at_most=count - 1)
        self.obstacles[i] = self.obstacles[i].at(position, orientation)

    def set_parameter(self, index: int, value: float) -> None:
        """Sets one of the skill's parameters, with a new fit if it needs one."""
        self.skill = self.parameters[index].apply(value)
        self.__dict__.pop("_quick", None)  # it answers with the old value

    @property
    def corrections(self) -> int:
        """The number of corrections that can be undone."""
        return len(self.skill.corrections) if isinstance(self.skill, CorrectedSkill) else 0

    def correct(self, time: float, position: ArrayLike) -> None:
        """Moves the tip's point at a time, s, of the present motion to a position (3,), m."""
        around = tuple(self.obstacles) if "obstacles" in self.skill.supports else ()
        query = self._query(_STEP)
        self.skill = self.skill.corrected(
            time,
            position,
            start=query.start,
            goal=query.goal,
            duration=self.duration,
            obstacles=around,
        )
        self.__dict__.pop("_quick", None)

    def undo(self) -> None:
        """Takes the last correction back."""
        if isinstance(self.skill, CorrectedSkill):
            self.skill = self.skill.undone()
            self.__dict__.pop("_quick", None)

    def asked_skill(self) -> Skill | None:
        """The skill whose uncertainty ends at the goal; None if it cannot be conditioned on it."""
        if not isinstance(self.skill, Conditioned):
            return self.skill
        try:
            goal = self._query(_STEP).goal
            return self.skill if goal is None else self.skill.condition(self.skill.duration, goal)
        except LeadthroughError:
            return None

    @property
    def via(self) -> Sequence[Float64Array]:
        """Points (3,) that the tip's path was moved to, for the present goal."""
        if not isinstance(self.skill, CorrectedSkill) or not self.corrections:
            return ()
        try:
            points = self.skill.corrected_points(**self._query(_STEP).arguments())
        except LeadthroughError:
            return ()
        return tuple(self.arm.forward_kinematics(points)[0] if self._is_of_joints else points)

    def preview(self) -> Answer:
        """A quick answer, which a check of the whole arm may still refuse."""
        return self._answer(_PREVIEW_STEP, preview=True)

    def plan(self) -> Answer:
        """The skill's own answer, with a collision check of the whole arm."""
        return self._answer(_STEP, preview=False)

    def _answer(self, dt: float, *, preview: bool) -> Answer:
        begin = time.perf_counter()
        path, joints, wanted, trouble, verdict = None, None, None, "", ""
        try:
            if self.obstacles and not preview:
                path, joints = self._planned(dt)
                wanted = self._path_of_the_tip_alone(dt, preview=False)
            else:
                motion = self._motion(dt, preview=preview)
                path = wanted = tip_path(self.arm, motion)
                joints = self._followed(motion)
            if not preview:
                verdict = str(self.arm.check(joints, self.scene))
        except LeadthroughError as error:
            trouble = str(error)
            if path is None:
                path = self._path_of_the_tip_alone(_PREVIEW_STEP, preview=True)
        others = () if preview or wanted is None else self._other_ways(dt, wanted)
        return Answer(path, joints, trouble, verdict, time.perf_counter() - begin, wanted, others)

    def _other_ways(self, dt: float, wanted: Float64Array) -> tuple[Float64Array, ...]:
        count = len(getattr(self.skill, "modes", ()))
        modes = range(count) if count > 1 else ()
        ways = [self._path_of_the_tip_alone(dt, preview=False, mode=i) for i in modes]
        return tuple(way for way in ways if way is not None and not np.array_equal(way, wanted))

    def _planned(self, dt: float) -> tuple[Float64Array, JointTrajectory]:
        """The path of the tip and the joints, the whole arm clear of the obstacles."""
        plan = partial(
            motion_planning.plan_motion, self.skill, self.arm, self.scene, self._query(dt)
        )
        try:
            planned = plan(q0=self._first)
        except IkFailure:
            if self._first is None:
                raise
            planned = plan()
        self._first, self._last = planned.joints.positions[0], planned.joints
        self._may_search = True
        return planned.tip.positions, planned.joints

    def _path_of_the_tip_alone(
        self, dt: float, *, preview: bool, mode: int | None = None
    ) -> Float64Array | None:
        """The path that the skill means, whether the arm can follow it or not; None if none."""
        try:
            return tip_path(self.arm, self._motion(dt, preview=preview, mode=mode))
        except LeadthroughError:
            return None

    def _query(self, dt: float) -> motion_planning.Query:
        start, goal = (
            None if end is None else end.target() for end in (self.end("start"), self.end("goal"))
        )
        return motion_planning.Query(start, goal, self.duration, dt)

    def _motion(self, dt: float, *, preview: bool, mode: int | None = None) -> Motion:
        query = self._query(dt).arguments() | ({} if mode is None else {"mode": mode})
        if "obstacles" in self.skill.supports:
            query["obstacles"] = tuple(self.obstacles)
        return (self._quick if preview else self.skill).generate(**query)

    def _followed(self, motion: Trajectory | PoseTrajectory | JointTrajectory) -> JointTrajectory:
        if isinstance(motion, JointTrajectory):
            return in_order(motion, self.arm.joint_names, "skill")
        joints = self._next_to_the_last(motion) or self._searched(motion)
        self._first, self._last = joints.positions[0], joints
        self._may_search = True
        return joints

    def _next_to_the_last(self, motion: Trajectory | PoseTrajectory) -> JointTrajectory | None:
        """The arm as if there were no obstacles, or else next to where it went around them last."""
        if self._first is None or not self.obstacles:
            return None
        around = self._around(self._given.margin)
        for posture, pull in ((None, None), (self._last, _PULL)):
            try:
                joints = self.arm.follow(
                    motion,
                    q0=self._first,
                    options=FollowOptions(posture=posture, nullspace_gain=pull),
                )
            except IkFailure:
                continue
            if around.clear_along(joints.positions):
                self._has_ample_room = True
                return joints
        return None

    def _searched(self, motion: Trajectory | PoseTrajectory) -> JointTrajectory:
        """A detour around the obstacles, searched until that fails."""
        if not self.obstacles or self._first is None:
            return self._from_any_posture(motion)
        if not self._may_search:
            raise LeadthroughError("an obstacle blocks the arm; release it to search for a detour")
        self._may_search = False
        return self._from_the_same_posture(motion, self._first)

    def _from_any_posture(self, motion: Trajectory | PoseTrajectory) -> JointTrajectory:
        """As before if possible: an arm that jumps while one drags is hard to look at."""
        try:
            return self.arm.follow(motion, q0=self._first, scene=self._required)
        except IkFailure:
            if self._first is None:
                raise
        return self.arm.follow(motion, scene=self._required)

    def _from_the_same_posture(
        self, motion: Trajectory | PoseTrajectory, first: Float64Array
    ) -> JointTrajectory:
        """A detour from a posture (joints,), by one short search at each distance."""
        if self._has_ample_room:
            try:
                return self._quickly_around(motion, first, _AMPLE)
            except IkFailure:
                self._has_ample_room = False
        return self._quickly_around(motion, first, self._given.margin)

    def _quickly_around(
        self, motion: Trajectory | PoseTrajectory, first: Float64Array, margin: float
    ) -> JointTrajectory:
        around = replace(self._around(margin), max_attempts=1)
        return follow(self.arm, motion, q0=first, options=FollowOptions(), around=around)

    @property
    def _required(self) -> Scene | None:
        """The scene, if there are obstacles to keep clear of."""
        return self.scene if self.obstacles else None

    def _around(self, margin: float) -> CollisionTest:
        scene = replace(self.scene, margin=margin).for_planning()
        return CollisionTest(self.arm._collision, scene)

    @cached_property
    def _quick(self) -> Generator:
        return self.skill.preview() if isinstance(self.skill, Previewed) else self.skill


def parted(target: Target) -> tuple[ArrayLike, ArrayLike | None]:
    """Position and orientation of a goal; the latter None for a position alone."""
    if isinstance(target, tuple) and len(target) == 2:
        return target[0], target[1]
    return target, None


Change = Callable[[Replanner], None]


class Replanning:
    """A replanner that answers in a thread of its own: after changes quickly, at rest in full."""

    def __init__(self, planner: Replanner, *, planned: bool) -> None:
        self.planner = planner
        self._worker = ThreadPoolExecutor(1)
        self._changes: list[Change] = []
        self._is_coarse = not planned
        self._job: Future[Answer] | None = None
        self._worker.submit(planner.preview)  # prepares what the first drag would wait for

    @property
    def idle(self) -> bool:
        """Whether all changes have been answered in full."""
        return self._job is None and not self._changes and not self._is_coarse

    def request(self, change: Change) -> None:
        """Plans anew after a change; those that come meanwhile are answered together."""
        self._changes.append(change)
        self._begin()

    def collect(self) -> tuple[Answer, bool] | None:
        """An answer that has come, and whether it is in full; starts the next one."""
        found = None
        if self._job is not None and self._job.done():
            found, self._job = (self._job.result(), not self._is_coarse), None
        self._begin()
        return found

    def _begin(self) -> None:
        if self._job is None and (self._changes or self._is_coarse):
            changes, self._changes = self._changes, []
            self._is_coarse = bool(changes)
            self._job = self._worker.submit(self._answer, changes)

    def close(self) -> None:
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _answer(self, changes: Sequence[Change]) -> Answer:
        try:
            for change in changes:
                change(self.planner)
        except LeadthroughError as error:
            return Answer(None, None, str(error), "", 0.0)
        return self.planner.preview() if changes else self.planner.plan()
