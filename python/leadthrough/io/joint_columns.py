"""Joint trajectories as columns, one for each joint and quantity."""

from __future__ import annotations

from collections.abc import Mapping

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.headers import JOINT_SUFFIXES, Columns
from leadthrough.motion import JointTrajectory


def checked_joint_names(trajectory: JointTrajectory) -> Columns:
    """The joints' names."""
    if not isinstance(trajectory, JointTrajectory):
        raise InvalidInput(
            f"trajectory: expected a JointTrajectory, got {type(trajectory).__name__}"
        )
    names = trajectory.joint_names
    if not names:
        raise InvalidInput(
            "trajectory: expected joint_names, which the robot needs, got none; "
            "`leadthrough plan --robot` writes them, "
            "in Python JointTrajectory(..., joint_names=arm.joint_names)"
        )
    if len(set(names)) != len(names) or not all(name and name.isprintable() for name in names):
        raise InvalidInput(
            f"trajectory: expected different, printable joint_names, got {list(names)}"
        )
    return names


def quantities(trajectory: JointTrajectory) -> dict[str, Float64Array]:
    """The positions, velocities and accelerations (n, joints) that a trajectory has, by name."""
    found = {name: getattr(trajectory, name) for name in JOINT_SUFFIXES}
    return {name: values for name, values in found.items() if values is not None}


def joint_columns(joints: Columns, values: Mapping[str, Float64Array]) -> dict[str, Float64Array]:
    """A column (n,) for each quantity of each joint, named as `headers.derivatives` finds it."""
    return {
        name + JOINT_SUFFIXES[quantity]: array[:, i]
        for quantity, array in values.items()
        for i, name in enumerate(joints)
    }
