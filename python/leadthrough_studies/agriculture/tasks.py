"""Four agricultural tasks of a TIAGo in 16 subtasks, and the postures through which it is guided.

Lauretti et al. 2023, section 2.2, name the subtasks and the first target; the rest is assumed here:

- The torso is held at 0.25 m. The tool is a point 0.2 m beyond the wrist; a capsule 8 cm thick
  stands for the hand. The arm's base frame is on the axis of the first joint, x to the front, z up.
- The paper draws the layout of its nine targets and states the first: [20, -20, -40] cm for
  subtasks 1-2, 2-2 and 3-2, [50, -20, 0] cm for 4-1. From there, our targets lie on a 3 x 3 grid
  10 cm apart: horizontal (to the front and to the left) or vertical (up and to the left).
- Home, rack, bucket, seeds, can and crate are postures chosen by hand, the same in every
  repetition. At a target, the tool point is on the target, in the posture nearest to one chosen by
  hand for the middle of the grid.
- The tool rotates about the wrist as its use requires: scooping and turning over the soil, letting
  seeds fall, pouring and returning, twisting a fruit off its stem.
- As in the paper, the only obstacles are the floor and the robot itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.shapes import Box, Capsule

TORSO = 0.25  # m
SPACING = 0.1  # m, between targets
ARM_BASE = np.array([0.09305, 0.014, 0.7375 + TORSO])  # the first joint, in the robot's frame
CORNERS = (0, 1, 3, 4)  # targets at a corner of a cell of the grid
_TOOL = (0.0, 0.0, 0.2)  # m, beyond the last link
_ABOVE = np.array([0.0, 0.0, 0.1])  # m, from where a target is approached

POSTURES: dict[str, tuple[float, ...]] = {
    "home": (0.3, -0.8, -0.6, 1.9, -1.2, 0.9, 1.2),
    "rack": (1.1, -0.46, 1.1, 1.97, -0.84, -1.06, -0.23),
    "bucket": (0.55, 0.42, -0.17, 1.83, 0.87, 0.25, 0.0),
    "seeds": (1.45, -0.12, -0.91, 2.03, 0.33, -0.98, 1.5),
    "can": (1.18, -0.69, 1.24, 1.94, -0.81, -0.89, -1.4),
    "crate": (0.75, 0.42, 0.33, 1.82, -1.38, 0.45, -2.0),
    # The straight path from home would lead through the robot.
    "beside the rack": (0.36, -0.44, 0.38, 1.63, -0.61, -0.58, 0.04),
    "beside the can": (1.17, -0.35, -0.2, 1.63, -1.27, -0.31, -0.58),
}
# The posture at the middle of a grid.
_AT_TARGET: dict[str, tuple[float, ...]] = {
    "digging": (1.51, 0.41, 0.35, 2.11, -0.94, 0.43, -1.4),
    "seeding": (2.12, -0.03, 0.46, 1.88, 0.98, -0.66, 1.5),
    "irrigation": (2.04, -0.04, 0.59, 1.72, -1.54, 0.87, -1.3),
    "harvesting": (0.34, -0.15, -2.06, 1.8, 1.05, -0.75, 1.5),
}


@dataclass(frozen=True)
class Turned:
    """A posture after rotations of joints (by number, from 1), in rad."""

    posture: str
    turns: Mapping[int, float]


Stop = str | Turned


@dataclass(frozen=True)
class Subtask:
    """A subtask.

    Attributes:
        number: its number in the paper.
        title: short description.
        stops: the postures it passes: "target" and "above" depend on the target, others are in
            POSTURES.
        gripper: state of the gripper after the subtask: "closed", "opened" or empty for no change.
    """

    number: str
    title: str
    stops: tuple[Stop, ...]
    gripper: str = ""

    @property
    def ends_at_target(self) -> bool:
        """Whether its end depends on the target."""
        return _moves_with_target(self.stops[-1])

    @property
    def depends_on_target(self) -> bool:
        """Whether any of its postures depends on the target."""
        return any(_moves_with_target(stop) for stop in self.stops)


def _moves_with_target(stop: Stop) -> bool:
    return "target" in (stop, getattr(stop, "posture", ""))


_SCOOPED = Turned("target", {5: 1.5, 6: -1.2, 7: 2.2})
_SCATTERED = Turned("target", {5: -1.2, 7: -2.6})
_POURED = Turned("target", {5: 1.3, 7: 2.5})
_TWISTED = Turned("target", {5: -1.5, 7: -2.6})
_TURNED_OVER = Turned("bucket", {5: -1.6, 7: -1.8})

TASKS: dict[str, tuple[Subtask, ...]] = {
    "digging": (
        Subtask("1-1", "tool reaching", ("home", "beside the rack", "rack"), "closed"),
        Subtask("1-2", "digging", ("rack", "above", "target", _SCOOPED)),
        Subtask("1-3", "soil placing into the bucket", (_SCOOPED, "bucket", _TURNED_OVER)),
        Subtask("1-4", "tool placing", (_TURNED_OVER, "bucket", "rack"), "opened"),
        Subtask("1-5", "homing", ("rack", "beside the rack", "home")),
    ),
    "seeding": (
        Subtask("2-1", "seed reaching", ("home", "seeds"), "closed"),
        Subtask("2-2", "seed placing", ("seeds", "above", "target", _SCATTERED), "opened"),
        Subtask("2-3", "homing", (_SCATTERED, "home")),
    ),
    "irrigation": (
        Subtask("3-1", "reaching the watering can", ("home", "beside the can", "can"), "closed"),
        Subtask("3-2", "irrigation", ("can", "above", "target", _POURED, "target")),
        Subtask("3-3", "watering can placing", ("target", "can"), "opened"),
        Subtask("3-4", "homing", ("can", "beside the can", "home")),
    ),
    "harvesting": (
        Subtask("4-1", "vegetable reaching", ("home", "above", "target"), "closed"),
        Subtask("4-2", "vegetable detaching", ("target", _TWISTED)),
        Subtask("4-3", "vegetable placing into the crate", (_TWISTED, "crate"), "opened"),
        Subtask("4-4", "homing", ("crate", "home")),
    ),
}


@dataclass(frozen=True)
class Holding:
    """How a person holds the arm, beside the postures here.

    Attributes:
        offsets: rad, added to the joints (7,) of a posture, by its name; at targets by the task's.
        turn: factor of the tool's rotations.
    """

    offsets: Mapping[str, Float64Array] = field(default_factory=dict)
    turn: float = 1.0


CHOSEN = Holding()
_OFFSET = 0.3  # rad, standard deviation of each joint
_TURNS = (0.7, 1.3)


def drawn(rng: np.random.Generator) -> Holding:
    """A person's own way of holding the arm: the same in all subtasks and repetitions."""
    names = [*POSTURES, *_AT_TARGET]
    return Holding({name: rng.normal(0.0, _OFFSET, 7) for name in names}, rng.uniform(*_TURNS))


def load_arm() -> Arm:
    """The seven joints of the arm, with the hand."""
    hand = Capsule(0.04, 0.06, np.array([0.0, 0.0, -0.1]))
    arm = Arm.load("tiago").lock_joints({"torso_lift_joint": TORSO})
    return arm.with_tool(_TOOL).with_attached(hand)


def floor() -> Box:
    """The floor, in the robot's frame."""
    return Box(np.array([6.0, 6.0, 0.1]), np.array([0.0, 0.0, -0.05]))


def targets(task: str) -> Float64Array:
    """The nine targets (9, 3) of a task, m in the robot's frame, row by row from the paper's."""
    first, second = np.meshgrid(SPACING * np.arange(3), SPACING * np.arange(3), indexing="ij")
    left, away, zero = second.ravel(), first.ravel(), np.zeros(9)
    if task == "harvesting":
        offsets = np.column_stack([zero + 0.5, left - 0.2, away])
    else:
        offsets = np.column_stack([away + 0.2, left - 0.2, zero - 0.4])
    return np.asarray(ARM_BASE + offsets)


def amid(task: str, i: int) -> Float64Array:
    """The position (3,) between target i, one of CORNERS, and its three neighbours, m."""
    return np.asarray(targets(task)[[i, i + 1, i + 3, i + 4]].mean(axis=0))


def postures(
    arm: Arm, task: str, subtask: Subtask, target: Float64Array, holding: Holding = CHOSEN
) -> Float64Array:
    """The postures (n, joints) through which the arm is guided in a subtask.

    Args:
        arm: the TIAGo.
        task: name of the task.
        subtask: the subtask.
        target: position (3,), m.
        holding: how the person holds the arm.

    Raises:
        RuntimeError: if the arm does not reach the target.
    """
    return np.array([_posture(arm, task, stop, target, holding) for stop in subtask.stops])


def _posture(
    arm: Arm, task: str, stop: Stop, target: Float64Array, holding: Holding
) -> Float64Array:
    limits = arm.limits.lower, arm.limits.upper
    if isinstance(stop, Turned):
        turned = _posture(arm, task, stop.posture, target, holding)
        for joint, turn in stop.turns.items():
            turned[joint - 1] += holding.turn * turn
        return np.clip(turned, *limits)
    offset = holding.offsets.get(stop if stop in POSTURES else task, 0.0)
    held = POSTURES.get(stop, _AT_TARGET[task])
    posture = np.clip(np.array(held) + offset, *limits)
    if stop in POSTURES:
        return posture
    found = arm.inverse_kinematics(target, q0=posture)
    if stop == "above":
        found = arm.inverse_kinematics(target + _ABOVE, q0=found.q)
    if not found.success:
        raise RuntimeError(f"{task}: the arm does not reach {stop} at {target}")
    return found.q
