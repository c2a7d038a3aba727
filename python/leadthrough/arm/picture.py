"""The drawing of an arm: its links in the middle of the joints' ranges, and the ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadthrough.arm.link_poses import link_poses
from leadthrough.check import Float64Array
from leadthrough.drawing import palette
from leadthrough.drawing.panels import Dot, Line, Panel, bars, on_paper, triad

if TYPE_CHECKING:
    from leadthrough.arm.definition import ArmDefinition

_UNBOUNDED = np.pi  # rad or m, drawn on both sides of a joint without limits
_LONGEST = 18  # letters of a joint's name


def panels(arm: ArmDefinition) -> list[Panel]:
    """The arm seen obliquely, and the ranges of its joints."""
    return [_links(arm), _ranges(arm)]


def _links(arm: ArmDefinition) -> Panel:
    q = arm._chain.middle
    poses = link_poses(arm, q[None])
    joints = arm._robot.path(arm.base, arm.tip)
    links = [arm._robot.links.index(arm.base)]
    for joint in joints:
        links.append(joint.child if joint.parent == links[-1] else joint.parent)
    at = np.stack([poses[arm._robot.links[link]][1][0] for link in links])
    tip = arm._chain.forward_kinematics(q[None])[0]
    way = on_paper(np.vstack([at, tip]))
    extent = float(np.ptp(way, axis=0).max()) or 1.0
    moving = [i for i, joint in enumerate(joints, 1) if joint.name in arm.joint_names]
    dots = [_dot(way[i], "", palette.AMBER, 3.0) for i in moving]
    axes, names = triad(way.min(axis=0) - [0.3 * extent, 0.0], 0.2 * extent)
    link = Line(way[:, 0], way[:, 1], colour=palette.BLUE, width=4.0)
    ends = [_dot(way[0], "base", palette.GREY, 5.0), _dot(way[-1], "tip", palette.GREEN, 3.0)]
    title = f"{arm._robot.name}, reach at most {arm._chain.reach:.2f} m"
    return Panel(title, [*axes, link], dots=[*names, *dots, *ends], equal=True)


def _ranges(arm: ArmDefinition) -> Panel:
    rows = []
    for name, low, high in zip(arm.joint_names, arm.limits.lower, arm.limits.upper, strict=True):
        called = name if len(name) <= _LONGEST else f"...{name[-_LONGEST:]}"
        rows.append((called, _bounded(low, -_UNBOUNDED), _bounded(high, _UNBOUNDED)))
    return bars(rows, title="ranges of the joints", x_label="rad (m)")


def _dot(at: Float64Array, text: str, colour: str, radius: float) -> Dot:
    return Dot(float(at[0]), float(at[1]), text, colour, radius)


def _bounded(limit: float, instead: float) -> float:
    return float(limit) if np.isfinite(limit) else instead
