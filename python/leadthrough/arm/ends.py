"""The links of a robot as a tree, and where its arm may end."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import leadthrough._core as core

_NOT_OF_AN_ARM = ("fixed", "planar", "floating")
# Links of tools, and joints of fingers, by how arms' makers name them.
_TOOL = re.compile(r"(^|[_/-])(tool0|tcp|ee_link|flange)$", re.IGNORECASE)
_FINGER = re.compile(
    r"finger|gripper|jaw|knuckle|thumb|claw|hand|index|middle|ring|pinky|little", re.IGNORECASE
)


def moves(robot: core.Robot) -> bool:
    """Whether a joint of the robot moves."""
    return any(joint.kind not in _NOT_OF_AN_ARM for joint in robot.tree)


def proposed_tip(robot: core.Robot) -> str:
    """The tool's link after the most moving joints, else the last link before the fingers."""
    moving = {0: 0}  # joints before each link; a parent comes before its children
    for joint in robot.tree:
        before = moving.get(joint.parent)
        if before is None or (joint.kind != "fixed" and _is_finger(robot, joint)):
            continue
        moving[joint.child] = before + (joint.kind != "fixed" and joint.mimic is None)
    return _last(robot, moving)


def proposed_ends(document: str, recorded: Sequence[str] = ()) -> tuple[str, str]:
    """The base and tip of an arm: around the joints that were recorded, else as `proposed_tip`."""
    robot = core.Robot(document)
    first: dict[int, int] = {}  # the link before the recorded joints, by the link behind them
    behind: dict[int, int] = {}  # how many of them are before a link
    for joint in robot.tree:
        is_recorded = joint.name in recorded and not _is_finger(robot, joint)
        if is_recorded or (joint.kind == "fixed" and joint.parent in behind):
            first[joint.child] = first.get(joint.parent, joint.parent)
            behind[joint.child] = behind.get(joint.parent, 0) + is_recorded
    if not behind:
        return robot.links[0], proposed_tip(robot)
    tip = _last(robot, behind)
    return robot.links[first[robot.links.index(tip)]], tip


def _last(robot: core.Robot, joints: Mapping[int, int]) -> str:
    """The link behind the most joints, a tool's before others."""
    most = max(joints.values())
    names = [robot.links[i] for i, count in joints.items() if count == most]
    return max(names, key=lambda name: (name.endswith("tool0"), bool(_TOOL.search(name))))


def _is_finger(robot: core.Robot, joint: core.Joint) -> bool:
    """Whether a joint moves a finger: by its name, or that of the link, unless it is a palm."""
    link = robot.links[joint.child]
    return bool(_FINGER.search(joint.name) or re.search("finger|jaw|knuckle|thumb", link.lower()))


def link_tree(robot: core.Robot) -> str:
    """The links, each below its parent, with the joint between them."""

    def rows(link: int, depth: int) -> Iterator[str]:
        for joint in robot.tree:
            if joint.parent == link:
                yield f"{'  ' * depth}{robot.links[joint.child]} ({joint.name}, {joint.kind})"
                yield from rows(joint.child, depth + 1)

    return "\n".join([robot.links[0], *rows(0, 1)])
