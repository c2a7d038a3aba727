"""Which limit binds a trajectory, and when."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from leadthrough.arm.limits import JointLimits
from leadthrough.motion import JointTrajectory
from leadthrough.timing.scaling import limit_ratios

_KINDS = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Binding:
    """A stretch of time in which one limit is the nearest.

    start, end: s. joint: its name. kind: "velocity", "acceleration" or "jerk". ratio: the largest
    share of the limit that is used.
    """

    start: float
    end: float
    joint: str
    kind: str
    ratio: float


def binding_limits(trajectory: JointTrajectory, limits: JointLimits) -> list[Binding]:
    """What limits each stretch of a trajectory, in the order of time.

    Raises InvalidInput where trajectory and limits do not belong together.
    """
    joints, ratios = limit_ratios(trajectory, limits)
    if len(trajectory.times) == 1:
        return []
    nearest = ratios.reshape(len(ratios), -1).argmax(axis=1)
    changes = np.flatnonzero(np.diff(nearest)) + 1
    bounds = [0, *changes, len(nearest)]
    return [
        Binding(
            start=float(trajectory.times[first]),
            end=float(trajectory.times[last]),
            joint=joints[int(nearest[first]) % len(joints)],
            kind=_KINDS[int(nearest[first]) // len(joints)],
            ratio=float(ratios.reshape(len(ratios), -1)[first:last].max()),
        )
        for first, last in pairwise(bounds)
    ]
