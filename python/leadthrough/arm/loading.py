"""From a URDF's document to a robot, its ends and the limits of an arm's joints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from leadthrough import _core
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.errors import InvalidInput

# Bytes: above the core's own bound, which refuses the document with a reason.
_LARGEST_FILE = 2**25


def is_document(path_or_xml: Any) -> bool:
    """Whether this is a document, and no path."""
    return isinstance(path_or_xml, str) and path_or_xml.lstrip("\ufeff \t\r\n")[:1] == "<"


def read(path_or_xml: Any) -> str:
    """The document itself, or that of the file. Raises InvalidInput."""
    try:
        if is_document(path_or_xml):
            return str(path_or_xml.encode("utf-8"), "utf-8")
        with Path(path_or_xml).open("rb") as file:
            return str(file.read(_LARGEST_FILE), "utf-8")
    except (OSError, ValueError, TypeError) as error:
        raise InvalidInput(f"path_or_xml: expected a URDF or its path: {error}") from None


def only_leaf(robot: _core.Robot) -> str:
    """The link that the robot ends in. Raises InvalidInput where there are several."""
    if len(robot.leaves) > 1:
        raise InvalidInput(f"tip: the robot ends in several links; name one of {robot.leaves}")
    return robot.leaves[0]


def stated_limits(chain: _core.Chain) -> JointLimits:
    """The limits that the URDF states."""
    return JointLimits(
        tuple(chain.joint_names), chain.lower, chain.upper, chain.velocity, effort=chain.effort
    )


def complete(limits: Any, stated: JointLimits, robot: _core.Robot) -> JointLimits:
    """The limits asked for: those that are stated, or given, or stated and completed by a file."""
    if limits is None:
        return stated
    if isinstance(limits, JointLimits):
        return limits
    return read_limits(limits, stated, other_joints=robot.joints)
