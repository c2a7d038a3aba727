"""The arm that a command line names, and motions for it."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from leadthrough.arm import Arm
from leadthrough.arm.robot_files import find_robot
from leadthrough.cli import errors, reading
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, Motion


def load(
    name: str,
    limits: Path | None = None,
    base: str | None = None,
    tip: str | None = None,
    mesh_folder: Path | None = None,
) -> Arm:
    """The arm of a robot, by its name, or of a URDF, by its path."""
    with errors.naming(name="--robot", path_or_xml="--robot"):
        if _is_path(name):
            return Arm.from_urdf(
                Path(name),
                base=base,
                tip=tip,
                limits=limits,
                mesh_folders=mesh_folders(mesh_folder),
            )
        refuse("--robot FILE.urdf", mesh_folder=mesh_folder)
        return Arm.load(name, base=base, tip=tip, limits=limits)


def mesh_folders(given: Path | None) -> list[Path]:
    """The folder of --mesh-folder as a list, which is empty if none was given."""
    if given is not None and not given.is_dir():
        raise InvalidInput(f"mesh_folder: expected a folder, got {given}")
    return [] if given is None else [given]


def urdf_of(name: str) -> Path:
    """The URDF of a robot that `load` takes."""
    return Path(name) if _is_path(name) else find_robot(name).urdf


def _is_path(name: str) -> bool:
    return "/" in name or name.lower().endswith((".urdf", ".xml"))


def ranges(arm: Arm) -> dict[str, tuple[float, float]]:
    """The lower and upper limit of each joint, rad (m), as `read_demonstrations` takes them."""
    limits = arm.limits
    pairs = zip(limits.lower.tolist(), limits.upper.tolist(), strict=True)
    return dict(zip(arm.joint_names, pairs, strict=True))


def refuse(need: str, **given: object) -> None:
    """Refuses options that need something that is not there."""
    for option, value in given.items():
        if value is not None:
            name = option.replace("_", "-")
            raise InvalidInput(f"--{name}: only used with {need}; add it or leave --{name} out")


def joints_in(arm: Arm, file: Path) -> JointTrajectory:
    """The arm's joints of the only motion in a file."""
    return own_joints(arm, reading.one_motion(file, joints=ranges(arm)), str(file))


def own_joints(arm: Arm, motion: Motion, name: str) -> JointTrajectory:
    """The arm's joints of a motion, by their names; by their order if no name is the arm's."""
    if not isinstance(motion, JointTrajectory):
        raise InvalidInput(
            f"{name}: expected a joint motion, got a {type(motion).__name__}; "
            "`leadthrough plan --robot` makes joint motions of a skill's poses"
        )
    recorded = motion.joint_names
    strangers = not set(recorded) & set(arm.joint_names)
    if recorded and strangers and len(recorded) < len(arm.joint_names):
        raise InvalidInput(
            f"{name}: has {len(recorded)} joints, and the arm from {arm.base} to {arm.tip} has "
            f"{len(arm.joint_names)}: {', '.join(arm.joint_names)}; if it ends in a gripper, give "
            "the last link before it as --tip (`leadthrough info` lists the links)"
        )
    if recorded and strangers and len(recorded) == len(arm.joint_names):
        print(
            f"{name}: using joints {', '.join(recorded)} as {', '.join(arm.joint_names)}",
            file=sys.stderr,
        )
        motion = replace(motion, joint_names=arm.joint_names)
    return arm.joints_of(motion)
