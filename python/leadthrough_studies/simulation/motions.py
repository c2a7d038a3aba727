"""Motions of the other studies, as the arm is to run them: timed, with what the tip carries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from leadthrough.arm import Arm, JointLimits
from leadthrough.errors import LeadthroughError, NoPath
from leadthrough.io import lasa
from leadthrough.models import ProMP
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Scene
from leadthrough.timing import retime
from leadthrough_studies.agriculture.planners import planner_of
from leadthrough_studies.agriculture.skills import DURATION, STEP, learn
from leadthrough_studies.agriculture.study import on_the_arm
from leadthrough_studies.agriculture.tasks import TASKS, load_arm
from leadthrough_studies.elbow.scenes import drawn_scene
from leadthrough_studies.handwriting import demo
from leadthrough_studies.human.demonstrations import human

_PAYLOADS = {"panda": 1.0, "ur3": 1.0, "tiago": 0.5}  # kg
_CENTRE = (0.0, 0.0, 0.03)  # m from the tip, of what it carries
_OF_THE_TORQUE = 0.9  # fraction of the torque limits that the time law may use
_TOLERANCE = 1e-3  # rad, of the timed path
_REPETITIONS = (0, 2, 4, 6, 8)  # targets of the agriculture study
_WEIGHTS = 20
_DRAWN, _APART = 20, 1000
_OFF_ITSELF = 0.005  # m


@dataclass(frozen=True, eq=False)
class Given:
    """A motion that an arm can run, as far as its plan knows.

    Attributes:
        arm: with a payload.
        path: as the study made it.
        joints: the same, as fast as the limits of velocity, acceleration, jerk and torque allow.
    """

    arm: Arm
    path: JointTrajectory
    joints: JointTrajectory


def given(source: str, index: int, seed: int) -> Given | str:
    """A motion of a study; where it has none, the reason.

    Args:
        source: a key of SOURCES.
        index: number of the motion.
        seed: of the motions that are drawn at random.
    """
    try:
        arm, path = SOURCES[source](index, seed)
        name = arm.robot.name
        loaded = arm.with_payload(_PAYLOADS[name], _CENTRE)
        return Given(loaded, path, timed(loaded, path))
    except LeadthroughError as error:
        return str(error)


def timed(arm: Arm, path: JointTrajectory, *, faster: float = 1.0) -> JointTrajectory:
    """The fastest motion along a path inside the limits and nine tenths of the torques.

    Args:
        arm: the arm.
        path: any motion along the path.
        faster: factor on the limits of velocity, acceleration and jerk, at which the torque limits
            are left out, unless it is 1.
    """
    if faster == 1.0:
        return retime(
            path,
            arm.limits,
            path_tolerance=_TOLERANCE,
            inverse_dynamics=lambda q, qd, qdd: arm.inverse_dynamics(q, qd, qdd) / _OF_THE_TORQUE,
        )
    return retime(path, faster_limits(arm, faster), path_tolerance=_TOLERANCE)


def faster_limits(arm: Arm, factor: float) -> JointLimits:
    """The limits with those of velocity, acceleration and jerk times a factor."""
    rates = {
        name: factor * getattr(arm.limits, name) for name in ("velocity", "acceleration", "jerk")
    }
    return JointLimits(**(vars(arm.limits) | rates))


def _reach(name: str) -> Callable[[int, int], tuple[Arm, JointTrajectory]]:
    def made(index: int, seed: int) -> tuple[Arm, JointTrajectory]:
        arm = Arm.load(name)
        for drawn in range(_DRAWN):
            joints = drawn_scene(arm, name, seed, index + _APART * drawn, ()).joints
            # The obstacles are left out, and nothing else keeps the arm off itself.
            if arm.check(joints, Scene(self_collision_margin=_OFF_ITSELF)).ok:
                return arm, joints
        raise NoPath("no reach without a self-collision was drawn", reason="drawn")

    return made


def _handwriting(index: int, _: int) -> tuple[Arm, JointTrajectory]:
    config = demo.HandwritingConfig()
    arm = Arm.load(config.robot)
    written = demo.run(lasa.motions()[index], arm, config)
    return arm.with_attached(demo.pen(config)), written.joints


def _agriculture(index: int, seed: int) -> tuple[Arm, JointTrajectory]:
    every = [(task, subtask) for task, subtasks in TASKS.items() for subtask in subtasks]
    task, subtask = every[index % len(every)]
    repetition = _REPETITIONS[index // len(every)]
    arm = load_arm()
    learned = learn(arm, task, planner_of("anchored"), [repetition], seed=seed)
    skill = learned.skill(subtask, learned.targets[repetition])
    shown = learned.shown[subtask.number, repetition]
    _, joints = on_the_arm(arm, skill.generate(duration=DURATION, dt=STEP), shown.joints)
    if joints is None:
        raise NoPath("the arm cannot follow", reason="followed")
    return arm, joints


def _human(index: int, seed: int) -> tuple[Arm, JointTrajectory]:
    shown = human(1, np.random.default_rng([seed, index]))
    made = ProMP(weights=_WEIGHTS).fit(shown).generate()
    assert isinstance(made, JointTrajectory)
    return Arm.load("panda"), made


# How many motions there are of each source in the whole study, and what makes them.
SOURCES: dict[str, Callable[[int, int], tuple[Arm, JointTrajectory]]] = {
    "reaches of a Panda": _reach("panda"),
    "reaches of a UR3": _reach("ur3"),
    "handwriting": _handwriting,
    "agriculture": _agriculture,
    "human": _human,
}
