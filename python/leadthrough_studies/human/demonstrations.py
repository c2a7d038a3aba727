"""One reach of a Panda, demonstrated by a person and by damped least squares.

Yang, Liu and Pears draw their reach but do not state it, and their recordings are not public. Our
reach goes from the ready posture to the tool pose of `GOAL`, to the left of the base, which
requires large motions of joints 1, 3 and 5. The person is simulated (`demonstrator`): the joints
move at an irregular pace through postures off the straight line, with tremor, with or without a
pause, rounded to encoder steps. Damped least squares (the paper's equations 3 to 7) move the tool
along a straight line to the same pose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough_studies.damped_least_squares import DampedLeastSquares, follow_path
from leadthrough_studies.demonstrator import JointTeaching, guide_joints

ROBOT = "panda"
START = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])  # ready posture of the arm's maker
GOAL = np.array([0.6, 0.2, 0.6, -1.7, 0.9, 1.9, 0.4])
# Standard deviations of the via postures at 1/3 and 2/3 of the way, and of the end, rad.
_ASTRAY, _GOAL_SPREAD = 0.08, 0.03
# Standard deviations of the target poses of damped least squares, m and rad.
_TARGET_SPREAD = (0.02, 0.03)
_TEACHING = JointTeaching(
    duration=(5.0, 8.0), pauses=1, pause=(0.3, 0.8), tremor=5e-4, encoder=2**14
)
# Differences of a person from a straight motion of the joints at minimum jerk.
FACTORS = ("timing", "shape", "noise")
_DURATION = 4.0  # s, for damped least squares
_RATE = 100.0  # Hz
_REST = 1.0  # s, of standstill before and after a motion

Law = Callable[[Float64Array], Float64Array]


def constant(u: Float64Array) -> Float64Array:
    """The fraction of the path covered at constant speed."""
    return u


def servo(u: Float64Array) -> Float64Array:
    """The fraction of the path covered by steps that each cover the same part of the remainder."""
    return np.asarray((1.0 - np.exp(-6.0 * u)) / (1.0 - np.exp(-6.0)))


def human(
    count: int, rng: np.random.Generator, *, factors: Sequence[str] = FACTORS
) -> list[Demonstration]:
    """Demonstrations of the reach by a simulated person.

    Args:
        count: number of demonstrations.
        rng: source of all random numbers.
        factors: those of FACTORS that the person has.
    """
    teaching = _TEACHING
    if "timing" not in factors:
        teaching = replace(teaching, duration=(6.5, 6.5), pace=0.0, pauses=0)
    if "noise" not in factors:
        teaching = replace(teaching, tremor=0.0, encoder=2**40)
    shaped = float("shape" in factors)
    shown: list[Demonstration] = []
    for number in range(1, count + 1):
        between = START + np.outer((1.0 / 3.0, 2.0 / 3.0), GOAL - START)
        between += shaped * rng.normal(0.0, _ASTRAY, between.shape)
        end = GOAL + shaped * rng.normal(0.0, _GOAL_SPREAD, len(GOAL))
        postures = np.vstack([START, between, end])
        shown.append(guide_joints(postures, teaching, rng, name=f"human {number}"))
    return shown


def damped(
    arm: Arm, count: int, rng: np.random.Generator, *, law: Law = minimum_jerk_time_scaling
) -> list[Demonstration]:
    """Demonstrations of the reach by damped least squares, along straight lines of the tool.

    Args:
        arm: the Panda.
        count: number of demonstrations; the first ends at the goal, the others near it.
        rng: source of all random numbers.
        law: maps fractions of the time (n,) to fractions of the line covered.
    """
    position, orientation = arm.forward_kinematics(GOAL)
    shown: list[Demonstration] = []
    for number in range(count):
        spread = (number > 0) * np.repeat(_TARGET_SPREAD, 3) * rng.standard_normal(6)
        turned = rotations.compose(rotations.exp(spread[None, 3:]), orientation[None])[0]
        motion = _line(arm, position + spread[:3], turned, law)
        joints = follow_path(arm, motion, q0=START, settings=DampedLeastSquares()).joints
        shown.append(Demonstration(joints, name=f"DLS-IK {number + 1}"))
    return shown


def interpolated(arm: Arm, rng: np.random.Generator, *, rest: float = 0.0) -> Demonstration:
    """A linear joint motion at constant speed to the joints where damped least squares end.

    Args:
        arm: the Panda.
        rng: source of all random numbers.
        rest: standstill before and after the motion, s.
    """
    end = damped(arm, 1, rng)[0].motion.positions[-1]
    times = np.arange(round((_DURATION + 2.0 * rest) * _RATE) + 1) / _RATE
    fraction = np.clip((times - rest) / _DURATION, 0.0, 1.0)
    return Demonstration(JointTrajectory(times, START + np.outer(fraction, end - START)))


def laws(arm: Arm, rng: np.random.Generator) -> dict[str, Demonstration]:
    """One demonstration of the reach with each time law that the paper may have used."""
    return {
        "joints interpolated": interpolated(arm, rng),
        "joints interpolated, with rests": interpolated(arm, rng, rest=_REST),
        "line, constant speed": damped(arm, 1, rng, law=constant)[0],
        "line, servo": damped(arm, 1, rng, law=servo)[0],
        "line, minimum jerk": damped(arm, 1, rng)[0],
    }


def _line(arm: Arm, position: Float64Array, orientation: Float64Array, law: Law) -> PoseTrajectory:
    times = np.arange(round(_DURATION * _RATE) + 1) / _RATE
    first, turned = arm.forward_kinematics(START)
    fraction = law(times / _DURATION)
    ends = rotations.align_signs(np.stack([turned, orientation]))
    return PoseTrajectory(
        times,
        first + np.outer(fraction, position - first),
        rotations.interpolate(np.array([0.0, 1.0]), ends, fraction),
    )
