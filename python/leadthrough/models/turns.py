"""Joints of several demonstrations at one turn: an encoder may wrap where they begin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import sanity
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, MotionT, of_arm


def at_one_turn(motions: Sequence[MotionT]) -> list[MotionT]:
    """The motions, joints that are whole turns from those of most others moved to these."""
    joints = [each for each in map(of_arm, motions) if each is not None]
    if len(joints) < max(len(motions), 2):
        return list(motions)
    turns = _turns_apart(np.array([each.positions.mean(axis=0) for each in joints]))
    for i, j in np.argwhere(turns):
        sanity.warn(
            f"demonstrations[{i}]: {_name(joints[i], j)} is {2.0 * np.pi * turns[i, j]:+.4g} "
            "rad, whole turns, from the others and is learned at their turn; leave it out if the "
            "joint has to be where it was"
        )
    return [_moved(each, -2.0 * np.pi * own) for each, own in zip(motions, turns, strict=True)]


def _turns_apart(middles: Float64Array) -> Float64Array:
    """Whole turns (k, d) of joints from where they are in most of k motions, by their means."""
    turns = sanity.turns(middles - middles[0])
    return np.asarray(turns - [_usual(column) for column in turns.T])


def _usual(turns: Float64Array) -> float:
    """The most frequent of numbers (k,), and of several the least."""
    values, counts = np.unique(turns, return_counts=True)
    return float(values[np.lexsort([np.abs(values), -counts])[0]])


def _name(joints: JointTrajectory, number: int) -> str:
    return joints.joint_names[number] if joints.joint_names else f"joint number {number + 1}"


def _moved(motion: MotionT, by: Float64Array) -> MotionT:
    joints = of_arm(motion)
    if joints is None or not by.any():
        return motion
    moved: Any = replace(joints, positions=joints.positions + by)
    return moved if joints is motion else replace(motion, joints=moved)
