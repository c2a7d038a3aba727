"""Names of joints that a file can carry."""

from __future__ import annotations

from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory


def checked_joint_names(trajectory: JointTrajectory) -> tuple[str, ...]:
    """The joints' names, if each has one of its own. Raises InvalidInput."""
    if not isinstance(trajectory, JointTrajectory):
        raise InvalidInput(
            f"trajectory: expected a JointTrajectory, got {type(trajectory).__name__}"
        )
    names = trajectory.joint_names
    if not names:
        raise InvalidInput("trajectory: expected joint_names, got none; the robot needs them")
    if len(set(names)) != len(names) or not all(name and name.isprintable() for name in names):
        raise InvalidInput(
            f"trajectory: expected different, printable joint_names, got {list(names)}"
        )
    return names
