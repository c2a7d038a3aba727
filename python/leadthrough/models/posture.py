"""The arm's joints beside demonstrations of its tip, by phase: the demonstrated posture.

A redundant arm has many postures for a pose, and most arms several. The joints of several
demonstrations are averaged where they agree; another elbow or wrist is another posture, and the
most frequent one is taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import JointTrajectory, Motion, joints_with, lerp

NODES = np.linspace(0.0, 1.0, 201)
# Joints farther apart than this at any phase, rad or m, are another posture.
_APART = 1.0
_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Posture:
    """Joints at evenly spaced phases from 0 to 1."""

    names: tuple[str, ...]  # of the joints, or none
    rows: Float64Array  # (201, joints) rad or m

    def along(self, times: Float64Array, phases: ArrayLike) -> JointTrajectory:
        """The joints of a motion."""
        at = np.asarray(phases)
        rows = lerp(at, NODES, self.rows)
        return JointTrajectory(times, rows, joint_names=self.names)

    def every_round(self, times: Float64Array, rounds: Float64Array) -> JointTrajectory:
        """Joints of a motion that repeats: they repeat too, with whole turns if demonstrated."""
        gap = self.rows[-1] - self.rows[0]
        turns = _TURN * np.round(gap / _TURN)
        closed = self.rows - np.outer(NODES, gap - turns)
        number = np.floor(rounds)
        within = Posture(self.names, closed).along(times, rounds - number)
        positions = within.positions + np.outer(number, turns)
        return JointTrajectory(times, positions, joint_names=self.names)

    def in_order(self, names: tuple[str, ...]) -> Float64Array:
        """The rows with their columns in the order of `names`."""
        if self.names == names:
            return self.rows
        return self.rows[:, check.column_order(self.names, names, "joints")]

    def reversed(self) -> Posture:
        """The joints from the end to the start."""
        return Posture(self.names, self.rows[::-1].copy())

    @staticmethod
    def from_archive(settings: dict[str, Any], arrays: Mapping[str, Any]) -> Posture | None:
        """The posture in a file, taken out of its settings; None where there is none."""
        if "posture" not in settings:
            return None
        names = tuple(map(str, settings.pop("posture")))
        rows = check.frozen(arrays["posture"], "posture", shape=(len(NODES), len(names) or "k"))
        return Posture(names, rows)


def settings_of(posture: Posture | None) -> dict[str, Any]:
    """The plain values of a posture by name, for a file; nothing where there is none."""
    return {} if posture is None else {"posture": list(posture.names)}


def arrays_of(posture: Posture | None) -> dict[str, Float64Array]:
    """The arrays of a posture by name, for a file; nothing where there is none."""
    return {} if posture is None else {"posture": posture.rows}


def demonstrated_posture(
    motions: Sequence[Motion], phases: Sequence[Float64Array], weights: ArrayLike | None = None
) -> Posture | None:
    """The joints that went along with motions of the tip; None where none has any."""
    each = [_posture_of(motion, own) for motion, own in zip(motions, phases, strict=True)]
    return agreed(each, weights)


def agreed(postures: Sequence[Posture | None], weights: ArrayLike | None = None) -> Posture | None:
    """The mean of the postures that lie near the one with the most weight near it."""
    weight = np.ones(len(postures)) if weights is None else np.asarray(weights)
    known = [(own, each) for own, each in zip(weight, postures, strict=True) if each is not None]
    if not known:
        return None
    first = known[0][1]
    if len({each.rows.shape for _, each in known}) > 1:
        raise InvalidInput("joints: expected as many in all demonstrations")
    layers = np.array([each.in_order(first.names) for _, each in known])
    own_weights = np.array([own for own, _ in known])
    around = [_unwound_to(layers, middle) for middle in layers]
    near = [np.abs(a - m).max(axis=(1, 2)) <= _APART for a, m in zip(around, layers, strict=True)]
    chosen = int(np.argmax([own_weights[alike].sum() for alike in near]))
    alike = near[chosen]
    mean = np.average(around[chosen][alike], axis=0, weights=own_weights[alike])
    return Posture(first.names, mean)


def _unwound_to(layers: Float64Array, middle: Float64Array) -> Float64Array:
    """Joints (m, 201, joints) with the whole turns left out by which they differ from others."""
    offsets = (layers - middle).mean(axis=1, keepdims=True)
    return np.asarray(layers - _TURN * np.round(offsets / _TURN))


def _posture_of(motion: Motion, phases: Float64Array) -> Posture | None:
    joints = joints_with(motion)
    if joints is None:
        return None
    return Posture(joints.joint_names, lerp(NODES, phases, joints.positions))
