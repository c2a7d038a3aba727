"""The example that the guide is about: a person guides a UR3 through a reach, three times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough_studies.demonstrator import JointTeaching, guide_joints

ROBOT = "ur3"
_POSTURES = ((0.0, -1.6, 1.9, -1.9, -1.6, 0.0), (0.9, -1.3, 1.6, -1.9, -1.5, 0.6))  # rad
_RECORDINGS = 3
_SPREAD = 0.01  # rad, standard deviation of each joint of the postures at both ends
_REST = (0.3, 0.8)  # s, shortest and longest time that the arm stands still before and after
_TEACHING = JointTeaching(duration=(2.4, 3.2), pauses=0, tremor=5e-4, encoder=2**16)


def reaches(joint_names: Sequence[str], *, seed: int) -> list[Demonstration[JointTrajectory]]:
    """Recordings of the reach, named reach1, reach2 and reach3.

    Args:
        joint_names: names of the arm's six joints.
        seed: seed of the random number generator.
    """
    rng = np.random.default_rng(seed)
    shown = []
    for number in range(1, _RECORDINGS + 1):
        postures = _POSTURES + rng.normal(0.0, _SPREAD, np.shape(_POSTURES))
        guided = guide_joints(postures, _TEACHING, rng, name=f"reach{number}")
        motion = _between_rests(guided.motion, rng.uniform(*_REST, 2))
        shown.append(replace(guided, motion=replace(motion, joint_names=tuple(joint_names))))
    return shown


def _between_rests(motion: JointTrajectory, rests: Float64Array) -> JointTrajectory:
    """The motion with the arm standing still before and after it, as long as `rests` says, s."""
    step = motion.times[1] - motion.times[0]
    before, after = np.round(rests / step).astype(int)
    positions = np.pad(motion.positions, ((before, after), (0, 0)), mode="edge")
    times = step * np.arange(len(positions))
    return JointTrajectory(times.round(6), positions.round(6))
