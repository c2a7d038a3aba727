"""The links of a robot as a tree, and where its arm may end."""

from __future__ import annotations

import re
from collections.abc import Iterator

import leadthrough._core as core

_TOOL = re.compile(r"(^|[_/-])(tool0|tcp|ee_link|flange)$", re.IGNORECASE)
_GRIPPER = re.compile(r"finger|gripper|jaw|knuckle|thumb|claw|pad", re.IGNORECASE)


def proposed_tip(robot: core.Robot) -> str:
    """The tool's link after the most moving joints, else the last link before the fingers."""
    moving = {0: 0}  # joints before each link; a parent comes before its children
    for joint in robot.tree:
        moving[joint.child] = moving[joint.parent] + (joint.kind != "fixed")
    links = range(len(robot.links))
    arms = [i for i in links if not _GRIPPER.search(robot.links[i])] or list(links)
    tools = [i for i in arms if _TOOL.search(robot.links[i])]
    return robot.links[max(tools or arms, key=moving.__getitem__)]


def link_tree(robot: core.Robot) -> str:
    """The links, each below its parent, with the joint between them."""

    def rows(link: int, depth: int) -> Iterator[str]:
        for joint in robot.tree:
            if joint.parent == link:
                yield f"{'  ' * depth}{robot.links[joint.child]} ({joint.name}, {joint.kind})"
                yield from rows(joint.child, depth + 1)

    return "\n".join([robot.links[0], *rows(0, 1)])
