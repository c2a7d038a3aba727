"""Which limit binds a trajectory, and when."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from leadthrough.arm.limits import JointLimits
from leadthrough.motion import JointTrajectory
from leadthrough.timing.limits_report import limit_ratios

Kind = Literal["velocity", "acceleration", "jerk"]
_KINDS: tuple[Kind, ...] = ("velocity", "acceleration", "jerk")
# A limit binds from this fraction of it on: what is left is the time law's own margin.
_BINDS = 0.95


@dataclass(frozen=True)
class Binding:
    """A stretch of time in which one limit is the nearest, and binds throughout or nowhere.

    Attributes:
        start: first time, s.
        end: last time, s.
        joint: name of the joint.
        kind: which of its limits.
        ratio: largest fraction of the limit that is used.
    """

    start: float
    end: float
    joint: str
    kind: Kind
    ratio: float

    @property
    def binds(self) -> bool:
        """Whether the motion could not be faster there: at least 95 % of the limit is used."""
        return self.ratio >= _BINDS


def binding_limits(trajectory: JointTrajectory, limits: JointLimits) -> list[Binding]:
    """The limit that is nearest in each stretch of a trajectory, in the order of time.

    A stretch in which the nearest limit binds is told apart from one in which it does not.

    Args:
        trajectory: the motion.
        limits: limits of the same joints.

    Raises:
        InvalidInput: if the trajectory and the limits are not of the same joints.
    """
    joints, ratios = limit_ratios(trajectory, limits)
    if len(trajectory.times) == 1:
        return []
    flat = ratios.reshape(len(ratios), -1)
    nearest, binds = flat.argmax(axis=1), flat.max(axis=1) >= _BINDS
    changes = np.flatnonzero(np.diff(nearest) | np.diff(binds)) + 1
    return [
        Binding(
            start=float(trajectory.times[first]),
            end=float(trajectory.times[last]),
            joint=joints[int(nearest[first]) % len(joints)],
            kind=_KINDS[int(nearest[first]) // len(joints)],
            ratio=float(flat[first:last].max()),
        )
        for first, last in pairwise([0, *changes, len(nearest)])
    ]
