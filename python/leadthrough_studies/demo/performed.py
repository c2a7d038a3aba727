"""One scene of the demo, from its demonstrations to the joints of its arm, and what was checked."""

from __future__ import annotations

from dataclasses import dataclass

from leadthrough.arm import Arm, CollisionReport
from leadthrough.check import Float64Array
from leadthrough.models import ProMPSkill
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.shapes import Shape
from leadthrough.show.animation import Animation
from leadthrough.show.arm_scene import arm_scene
from leadthrough.timing import LimitsReport


@dataclass(frozen=True, eq=False)
class Performed:
    """A scene of the demo.

    Attributes:
        name: its name, also of its files.
        told: description of the task.
        model: the model that learned it.
        learned_from: who demonstrated what.
        asked: how the motion differs from those that were demonstrated.
        arm: that moves, with what it holds.
        demonstrations: that it was learned from.
        joints: the motion that the arm would run.
        limits: the check of the motion against the joints' limits.
        clearance: the check of the whole arm.
        path: (n, 3) of the tip, m; None for where the tip goes.
        obstacles: drawn beside the arm.
        goal: (3,) where the motion ends, m, if it is drawn.
        skill: whose spread is drawn.
    """

    name: str
    told: str
    model: str
    learned_from: str
    asked: str
    arm: Arm
    demonstrations: tuple[Demonstration, ...]
    joints: JointTrajectory
    limits: LimitsReport
    clearance: CollisionReport
    path: Float64Array | None = None
    obstacles: tuple[Shape, ...] = ()
    goal: Float64Array | None = None
    skill: ProMPSkill | None = None

    @property
    def ok(self) -> bool:
        """Whether the motion keeps all limits and the whole arm is clear."""
        return self.limits.ok and self.clearance.ok

    def drawn(self) -> Animation:
        """The scene to look at."""
        return arm_scene(
            self.arm,
            self.joints,
            demonstrations=self.demonstrations,
            path=self.path,
            skill=self.skill,
            obstacles=self.obstacles,
            goal=self.goal,
        )
