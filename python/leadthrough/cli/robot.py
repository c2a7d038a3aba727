"""The arm that a command line names, motions of its joints, and how they follow a plan."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

import leadthrough as lt
from leadthrough import check
from leadthrough.arm.robot_files import find_robot
from leadthrough.cli import output, parse, reading
from leadthrough.cli.options import ArmDetails
from leadthrough.io.table import Ranges, joints_told
from leadthrough.motion import Motion, joints_with, with_derivatives

# m or rad; the tip is this near to a path that is followed without tolerances.
_AS_PLANNED = 2e-5
UNITS = {
    "position_error": "m",
    "orientation_error": "rad",
    "start_from_recorded": "rad (m)",
    "goal_from_recorded": "rad (m)",
    "clearance": "m",
    "tip_deviation": "m",
}
# A start this far from the demonstrated one, rad or m, is another posture to a person beside it.
_ELSEWHERE = 0.3
# Ends of a motion, their rows, and what to do where the arm has another posture there.
_ENDS = (
    (
        *("start", 0, "starts"),
        "bring it there slowly, or set --posture to a recording to start as it does",
    ),
    (
        *("goal", -1, "ends"),
        "look at it with `leadthrough view`, or choose a goal nearer to the demonstrated one",
    ),
)
# Names of columns that number the joints.
_NUMBERED = re.compile(
    r"((?:actual_)?(?:q|j|joint|axis|a|theta|(?:joint_)?positions?)(?:_d)?[_\[]?)(\d+)\]?",
    re.IGNORECASE,
)


def load(name: str, details: ArmDetails) -> lt.Arm:
    named: Any = {"base": details.base, "tip": details.tip, "limits": details.limits}
    with output.naming(name="--robot", path_or_xml="--robot"):
        if _is_path(name):
            folders = mesh_folders(details.mesh_folder)
            return lt.Arm.from_urdf(Path(name), **named, mesh_folders=folders)
        refuse("--robot FILE.urdf", mesh_folder=details.mesh_folder)
        return lt.Arm.load(name, **named)


def mesh_folders(given: Path | None) -> list[Path]:
    """The folder of --mesh-folder as a list, which is empty if none was given."""
    if given is not None and not given.is_dir():
        raise lt.errors.InvalidInput(f"mesh_folder: expected a folder, got {given}")
    return [] if given is None else [given]


def urdf_of(name: str) -> Path:
    return Path(name) if _is_path(name) else find_robot(name).urdf


def _is_path(name: str) -> bool:
    return "/" in name or name.lower().endswith((".urdf", ".xml", ".xacro"))


def ranges(arm: lt.Arm) -> Ranges:
    """The range of each joint, as `read_demonstrations` takes them."""
    sliding = {joint.name for joint in arm.robot.tree if joint.kind == "prismatic"}
    pairs = zip(arm.limits.lower.tolist(), arm.limits.upper.tolist(), strict=True)
    named = zip(arm.joint_names, pairs, strict=True)
    return {name: (*pair, "m") if name in sliding else pair for name, pair in named}


def refuse(need: str, **given: object) -> None:
    """Refuses options that need something that is not there."""
    for option, value in given.items():
        if value is not None:
            name = option.replace("_", "-")
            raise lt.errors.InvalidInput(
                f"--{name}: only used with {need}; add it or leave --{name} out"
            )


def joints_in(arm: lt.Arm, file: Path) -> lt.JointTrajectory:
    return own_joints(arm, reading.one_motion(file, joints=ranges(arm)), str(file))


def own_joints(arm: lt.Arm, motion: Motion, name: str) -> lt.JointTrajectory:
    """The arm's joints of a motion, by their names; by their order if these are numbers only."""
    if not isinstance(motion, lt.JointTrajectory):
        raise lt.errors.InvalidInput(
            f"{name}: expected a joint motion, got a {type(motion).__name__}; "
            "`leadthrough plan --robot` makes joint motions of a skill's poses"
        )
    recorded = motion.joint_names
    strangers = not set(recorded) & set(arm.joint_names)
    if recorded and strangers and len(recorded) < len(arm.joint_names):
        raise lt.errors.InvalidInput(
            f"{name}: has {len(recorded)} joints, and the arm from {arm.base} to {arm.tip} has "
            f"{len(arm.joint_names)}: {', '.join(arm.joint_names)}; if it ends in a gripper, give "
            "the last link before it as --tip (`leadthrough info` lists the links)"
        )
    if strangers and len(recorded) == len(arm.joint_names):
        motion = _numbered(motion, arm.joint_names, name)
    with output.naming(trajectory=name):
        return arm.joints_of(motion)


def _numbered(motion: lt.JointTrajectory, names: Sequence[str], name: str) -> lt.JointTrajectory:
    """The motion with the arm's names, if its own number them: as these do, or else in order."""
    recorded = motion.joint_names
    told = joints_told(recorded, names)
    of = [names[i] for i in told if i is not None]
    found = [(each[1], int(each[2])) for each in map(_NUMBERED.fullmatch, recorded) if each]
    if not found or found != [(found[0][0], found[0][1] + i) for i in range(len(recorded))]:
        raise lt.errors.InvalidInput(
            f"{name}: expected the joints {', '.join(names)}, got {', '.join(recorded)}; if these "
            "are the same joints in this order, learn with --column "
            f"joints={','.join(recorded)}, or name the columns q1, q2, ..."
        )
    of = of if len(of) == len(names) else list(names)
    print(f"{name}: using joints {', '.join(recorded)} as {', '.join(of)}", file=sys.stderr)
    return replace(motion, joint_names=tuple(of))


@dataclass(frozen=True, eq=False)
class Followed:
    """A joint motion, and facts to print of it."""

    joints: lt.JointTrajectory  # of the arm
    facts: dict[str, Any]  # to print, by name


def generated(skill: lt.models.Skill[Motion], query: dict[str, Any]) -> Motion:
    """The skill's motion; of joints with the velocities and accelerations from rest to rest."""
    motion = skill.generate(**query)
    if not isinstance(motion, lt.JointTrajectory):
        return motion
    return with_derivatives(replace(motion, velocities=None, accelerations=None))


def followed(arm: lt.Arm, motion: Motion, how: dict[str, Any]) -> Followed:
    """The arm's joints along a motion; a motion of joints is the arm's already."""
    if isinstance(motion, lt.JointTrajectory):
        return Followed(own_joints(arm, motion, "the skill"), {})
    joints = arm.follow(motion, **how)
    return Followed(joints, _compared(arm, motion, joints, how))


def kept_clear(
    arm: lt.Arm,
    skill: lt.models.Skill[Motion],
    query: dict[str, Any],
    margin: float | None,
    how: dict[str, Any],
) -> Followed:
    """The arm's joints along a skill's motion, the whole arm clear of the obstacles."""
    asked = {name: value for name, value in query.items() if name != "obstacles"}
    scene = lt.Scene(query["obstacles"])
    if margin is not None:
        scene = lt.Scene(query["obstacles"], margin)
    planned = lt.plan_motion(skill, arm, scene, lt.Query(**asked), **how)
    facts = _compared(arm, planned.tip, planned.joints, how)
    facts["clearance"] = planned.clearance
    if planned.reasons:
        facts |= {"tip_deviation": planned.deviation, "reasons": "; ".join(planned.reasons)}
    return Followed(planned.joints, facts)


def _compared(
    arm: lt.Arm, motion: Any, joints: lt.JointTrajectory, how: dict[str, Any]
) -> dict[str, Any]:
    """Deviations of the arm from the planned tip and the demonstrated joints."""
    report = arm.path_report(joints, motion)
    options = how["options"]
    default = options.free is None and options.tolerances == lt.arm.FollowOptions().tolerances
    off = _off_the_path(report, always=not default)
    chosen = {} if options.free is not None else _freed(report, options)
    return chosen | off | _beside_recorded(arm, motion, joints)


def options_of(
    arm: lt.Arm, posture: str | None, tolerance: str | None, free_axes: Sequence[str] | None
) -> dict[str, Any]:
    """The arguments of `Arm.follow` that the command's options make."""
    options = lt.arm.FollowOptions()
    if tolerance is not None:
        position, orientation = parse.tolerances(tolerance, "--tolerance")
        options = lt.arm.FollowOptions(
            position_tolerance=position, orientation_tolerance=orientation
        )
    if free_axes is not None:
        free = [check.choice(axis, "--free-axis", get_args(lt.arm.Axis)) for axis in free_axes]
        options = replace(options, free=free)
    if posture is None:
        return {"q0": None, "options": options}
    if Path(posture).exists():
        recorded = joints_in(arm, Path(posture))
        return {"q0": None, "options": replace(options, posture=recorded)}
    given = parse.numbers(posture, "--posture")
    q = check.array(given, "--posture", shape=(len(arm.joint_names),))
    return {"q0": q, "options": replace(options, posture=q)}


def _freed(report: lt.arm.PathReport, options: lt.arm.FollowOptions) -> dict[str, list[str]]:
    """The axes that the arm left free by itself, because it has fewer than six joints."""
    asked = max(options.tolerances[1], _AS_PLANNED)
    angles = np.abs(report.turn).max(axis=0).tolist()
    axes = [f"r{axis}" for axis, angle in zip("xyz", angles, strict=True) if angle > asked]
    return {"free_axes": axes} if axes else {}


def _off_the_path(report: lt.arm.PathReport, *, always: object) -> dict[str, float]:
    """How far the tip is from what was planned, where that is not by rounding alone."""
    errors = {
        "position_error": float(report.position_error.max()),
        "orientation_error": float(report.orientation_error.max()),
    }
    return errors if always or max(errors.values()) > _AS_PLANNED else {}


def _beside_recorded(arm: lt.Arm, motion: Motion, joints: lt.JointTrajectory) -> dict[str, Any]:
    """Distance of the start from the demonstrated configuration, with a warning if it is large."""
    demonstrated = joints_with(motion)
    if demonstrated is None:
        return {}
    if not set(arm.joint_names) <= set(demonstrated.joint_names or arm.joint_names):
        output.warn(
            f"the skill was demonstrated with the joints {', '.join(demonstrated.joint_names)}, "
            "which --robot does not have, so this arm's posture is its own; --posture sets another"
        )
        return {}
    recorded = arm.joints_of(demonstrated).positions
    found = {}
    for name, index, verb, advice in _ENDS:
        away = np.abs(joints.positions[index] - recorded[index])
        farthest = int(np.argmax(away))
        found[f"{name}_from_recorded"] = float(away[farthest])
        if away[farthest] >= _ELSEWHERE:
            output.warn(
                f"{name}: {arm.joint_names[farthest]} is {away[farthest]:.3g} rad (m) "
                f"from the demonstrated one, so the arm {verb} in another posture; {advice}"
            )
    return found
