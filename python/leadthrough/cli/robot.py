"""The arm that a command line names, and motions for it."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from leadthrough.arm import Arm
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, Motion


def load(
    name: str, limits: Path | None = None, base: str | None = None, tip: str | None = None
) -> Arm:
    """A robot that comes with the package, by its name, or that of a URDF's path.

    Raises InvalidInput, InvalidRobot.
    """
    if "/" in name or name.lower().endswith((".urdf", ".xml")):
        return Arm.from_urdf(Path(name), base=base, tip=tip, limits=limits)
    if limits or base or tip:
        raise InvalidInput(
            f"--robot: expected a URDF's path beside --limits, --base and --tip, got {name!r}"
        )
    return Arm.load(name)


def refuse_without(name: str | None, **given: object) -> None:
    """Raises InvalidInput for options that are given and need a robot, where there is none."""
    for option, value in given.items():
        if name is None and value is not None:
            raise InvalidInput(f"--{option}: expected --robot beside it, got {value}")


def own_joints(arm: Arm, motion: Motion, name: str) -> JointTrajectory:
    """The arm's joints of a motion; if none of its joints has a name of the arm's, by their order.

    Raises InvalidInput.
    """
    if not isinstance(motion, JointTrajectory):
        raise InvalidInput(
            f"{name}: expected joints, got a {type(motion).__name__}; "
            "`leadthrough plan` with --robot follows a skill's poses"
        )
    recorded = motion.joint_names
    strangers = not set(recorded) & set(arm.joint_names)
    if recorded and strangers and len(recorded) == len(arm.joint_names):
        print(
            f"{name}: taking {', '.join(recorded)} for {', '.join(arm.joint_names)}",
            file=sys.stderr,
        )
        motion = replace(motion, joint_names=arm.joint_names)
    return arm.joints_of(motion)
