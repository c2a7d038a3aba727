"""Joint motions of an arm whose tip follows what a command planned, and how they differ from it."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.arm.recorded import warn_of_another_arm
from leadthrough.cli import parse, reading
from leadthrough.cli import robot as robots
from leadthrough.motion import JointTrajectory, Motion, joints_with

# A start this far from where the arm was shown, rad or m, is another posture to a person beside it.
_ELSEWHERE = 0.3


@dataclass(frozen=True, eq=False)
class Followed:
    """A joint motion, and what there is to tell of it.

    Attributes:
        joints: of the arm.
        facts: what to print, by name.
    """

    joints: JointTrajectory
    facts: dict[str, Any]


def followed(arm: Arm, motion: Motion, posture: str | None, as_shown: Motion) -> Followed:
    """The arm's joints along a motion; a motion of joints is the arm's already.

    Warns on stderr where the arm does not start as it was shown.

    Args:
        arm: the arm that is to move.
        motion: what a skill planned.
        posture: the option `--posture`: joint positions, or the file of a recording.
        as_shown: the skill's own motion, without a new start or goal.

    Raises:
        InvalidInput: if the posture is not the arm's, or the motion neither joints nor poses.
        IkFailure: if the arm cannot follow.
    """
    if isinstance(motion, JointTrajectory):
        return Followed(robots.own_joints(arm, motion, "the skill"), {})
    warn_of_another_arm(arm._chain, as_shown)
    joints = _along(arm, motion, posture)
    return Followed(joints, _beside_shown(arm, motion, joints))


def _along(arm: Arm, motion: Any, posture: str | None) -> JointTrajectory:
    if posture is None:
        return arm.follow(motion)
    if not Path(posture).exists():
        given = parse.numbers(posture, "--posture")
        wished = check.array(given, "--posture", shape=(len(arm.joint_names),))
        return arm.follow(motion, seed=wished, posture=wished)
    stood = robots.own_joints(arm, reading.one_motion(Path(posture)), posture)
    return arm.follow(motion, posture=stood)


def _beside_shown(arm: Arm, motion: Motion, joints: JointTrajectory) -> dict[str, Any]:
    """How far the arm starts from where it was shown, with a warning if that is far."""
    shown = joints_with(motion)
    if shown is None:
        return {}
    if not set(arm.joint_names) <= set(shown.joint_names or arm.joint_names):
        print(
            f"warning: the skill was shown with the joints {', '.join(shown.joint_names)}, which "
            "--robot does not have, so this arm's posture is its own; --posture sets another",
            file=sys.stderr,
        )
        return {}
    away = np.abs(joints.positions[0] - arm.joints_of(shown).positions[0])
    farthest = int(np.argmax(away))
    if away[farthest] >= _ELSEWHERE:
        print(
            f"warning: start: {arm.joint_names[farthest]} is {away[farthest]:.3g} rad (m) from "
            "where it was shown, so the arm starts in another posture; bring it there slowly, or "
            "set --posture to a recording to start as it does",
            file=sys.stderr,
        )
    return {"start_from_shown": float(away[farthest])}
