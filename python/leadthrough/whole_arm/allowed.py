"""How far the tip may be off a path: as stated, or as far as the demonstrations spread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.errors import InvalidInput
from leadthrough.models.protocol import Distributed, Skill
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, normalised_times
from leadthrough.whole_arm.tip_paths import TipMotion

Deviation = tuple[ArrayLike, ArrayLike]
_SPACE = 3  # coordinates of a position


def room_beside(
    skill: Skill[Motion], deviation: Deviation | None, standard_deviations: float | None
) -> Callable[[TipMotion], Deviation | None]:
    """What tells of a path how far the tip may be off, as `Arm.follow` takes it."""
    if standard_deviations is None:
        return lambda _: deviation
    if deviation is not None:
        raise InvalidInput(
            "deviation: not used together with standard_deviations; give one of the two"
        )
    count = check.number(standard_deviations, "standard_deviations", above=0.0)
    chart = skill.chart if isinstance(skill, Distributed) else None
    if chart is None or chart.kind == "joints" or chart.size != _SPACE:
        raise InvalidInput(
            "standard_deviations: this skill has no covariance of the tip's positions; use a "
            "ProMP or GMR of poses or points in 3-D, or state deviation=(m, rad)"
        )
    return lambda path: _spread_beside(skill, path, count)


def _spread_beside(skill: Skill[Motion], path: TipMotion, count: float) -> Deviation:
    """The room beside a path that the skill's covariance allows."""
    assert isinstance(skill, Distributed)
    _, covariance = skill.distribution(normalised_times(path.times) * skill.duration)
    allowed = count**2 * covariance
    if isinstance(path, PoseTrajectory) and allowed.shape[1] > _SPACE:
        return allowed[:, :_SPACE, :_SPACE], allowed[:, _SPACE:, _SPACE:]
    return allowed[:, :_SPACE, :_SPACE], 0.0


def gone_through(arm: Arm, path: TipMotion, joints: JointTrajectory) -> TipMotion:
    """The motion that the tip goes through, with the path's times and events."""
    positions, orientations = arm.forward_kinematics(np.asarray(joints.positions))
    if isinstance(path, PoseTrajectory):
        return replace(path, positions=positions, orientations=orientations)
    return replace(path, positions=positions)
