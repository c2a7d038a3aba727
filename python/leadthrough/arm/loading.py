"""A URDF's document, the ends of an arm in it, and the limits of its joints."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TypeGuard

from leadthrough import _core
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.errors import InvalidInput

# Bytes: above the core's own bound, which refuses the document with a reason.
_LARGEST_FILE = 2**25


def is_document(path_or_xml: str | PathLike[str]) -> TypeGuard[str]:
    """Whether this is the document itself and not its path."""
    return isinstance(path_or_xml, str) and path_or_xml.lstrip("\ufeff \t\r\n")[:1] == "<"


def read(path_or_xml: str | PathLike[str]) -> str:
    """The document, or the text of the file."""
    try:
        if is_document(path_or_xml):
            return str(path_or_xml.encode("utf-8"), "utf-8")
        with Path(path_or_xml).open("rb") as file:
            return str(file.read(_LARGEST_FILE), "utf-8")
    except (OSError, ValueError, TypeError) as error:
        raise InvalidInput(f"path_or_xml: expected a URDF or its path: {error}") from None


def only_leaf(robot: _core.Robot) -> str:
    """The link that the robot ends in."""
    if len(robot.leaves) > 1:
        raise InvalidInput(
            f"tip: expected a link's name, as the robot ends in several links; name one of "
            f"{robot.leaves}"
        )
    return robot.leaves[0]


def stated_limits(chain: _core.Chain) -> JointLimits:
    """The limits that the URDF states; it has no acceleration or jerk."""
    return JointLimits(
        tuple(chain.joint_names), chain.lower, chain.upper, chain.velocity, effort=chain.effort
    )


def complete(
    limits: JointLimits | str | PathLike[str] | None, stated: JointLimits, robot: _core.Robot
) -> JointLimits:
    """The limits given, or those that are stated, completed by the file if there is one."""
    if limits is None:
        return stated
    if isinstance(limits, JointLimits):
        return limits
    return read_limits(limits, stated, other_joints=robot.joints)
