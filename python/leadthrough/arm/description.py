"""An arm as text to read."""

from __future__ import annotations

import io
import json
import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from leadthrough.arm.limits import zeros
from leadthrough.arm.link_geometry import link_poses
from leadthrough.arm.model import ArmModel
from leadthrough.arm.robot_files import find_mesh
from leadthrough.check import Float64Array
from leadthrough.drawing import Dot, Line, Panel, bars, on_paper, palette, triad

if TYPE_CHECKING:
    import leadthrough._core as core
# Quantities, with a heading that is no wider than its numbers, so that 80 columns do.
_COLUMNS = {
    "lower": "lower\nrad (deg)",
    "upper": "upper\nrad (deg)",
    "velocity": "speed\nrad/s",
    "acceleration": "accel.\nrad/s^2",
    "jerk": "jerk\nrad/s^3",
    "effort": "effort\nN m",
}
_MAX_WIDTH = 200  # characters; a table is as wide as its joints' names need it to be
_SLIDING = "; prismatic: m instead of rad, N instead of N m"
_INCOMPLETE = """\
The URDF states no acceleration or jerk. A limits file does; complete this one
or let `leadthrough info --write-limits` write one with assumed values:"""


def describe(arm: ArmModel) -> str:
    """See `Arm.describe`."""
    parts = [_head(arm), _joints(arm), "\n".join([*_zeros(arm), *_carried(arm)])]
    if arm.limits.acceleration is None or arm.limits.jerk is None:
        parts.append(f"{_INCOMPLETE}\n\n{arm.limits.template().rstrip()}")
    return "\n\n".join(parts) + "\n"


def _head(arm: ArmModel) -> str:
    count = len(arm.joint_names)
    path = arm._robot.path(arm.base, arm.tip)
    slides = any(joint.kind == "prismatic" for joint in path)
    links = ", ".join([arm.base, *(arm._robot.links[joint.child] for joint in path)])
    return (
        f"{arm._robot.name}: from {arm.base} to {arm.tip}, {count} joint{'s' * (count > 1)}\n"
        f"{_wrapped(f'links, each of which may be the tip: {links}')}\n"
        f"reach at most {arm._chain.reach:.3g} m from the first joint, "
        f"moving mass {arm._chain.mass:.4g} kg\n"
        f"joints are revolute unless a type is given{_SLIDING * slides}"
    )


def _joints(arm: ArmModel) -> str:
    table = Table(box=box.SIMPLE_HEAD, padding=0)
    table.add_column("joint")
    for heading in _COLUMNS.values():
        table.add_column(heading, justify="right")
    for joint in arm._robot.path(arm.base, arm.tip):
        if joint.name in arm.locked_joints:
            table.add_row(joint.name, f"locked at {arm.locked_joints[joint.name]:.4g}")
        elif joint.mimic is not None:
            mimic = joint.mimic
            table.add_row(joint.name, f"= {mimic.multiplier:.4g} {mimic.joint} {mimic.offset:+.4g}")
        elif joint.kind != "fixed":
            kind = "" if joint.kind == "revolute" else f" {joint.kind}"
            table.add_row(joint.name + kind, *_limits(arm, joint))
    text = io.StringIO()
    Console(file=text, width=_MAX_WIDTH, color_system=None).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()).strip("\n")


def _zeros(arm: ArmModel) -> Iterator[str]:
    """Remedies for limits of zero, by which many URDFs mean that nobody has looked them up."""
    if found := zeros(arm.limits):
        listed = ", ".join(f"{name} ({', '.join(keys)})" for name, keys in found.items())
        yield _wrapped(
            f"! limits of 0: {listed}. Such a velocity or range keeps a joint still, such an "
            "effort counts as unknown; put the maker's values into the limits file"
        )


def _limits(arm: ArmModel, joint: core.Joint) -> Iterator[str]:
    i = arm.joint_names.index(joint.name)
    for name in _COLUMNS:
        column = getattr(arm.limits, name)
        if column is None:
            yield "unknown"
        elif not np.isfinite(column[i]):
            yield "none"
        else:
            yield _number(column[i]) + _unit(name, joint, float(column[i]))


def _unit(name: str, joint: core.Joint, value: float) -> str:
    """The same value in degrees for a limit of an angle; the unit for a limit of a length."""
    if name not in ("lower", "upper"):
        return ""
    return " m" if joint.kind == "prismatic" else f" ({np.degrees(value):.4g})"


def _carried(arm: ArmModel) -> Iterator[str]:
    outside = set(arm.locked_joints) - {joint.name for joint in arm._robot.path(arm.base, arm.tip)}
    if outside:
        yield "also locked: " + ", ".join(
            f"{name} at {arm.locked_joints[name]:.4g}" for name in sorted(outside)
        )
    position, orientation = arm.tool
    yield f"tool: tip at {_numbers(position)} m, {_numbers(orientation)} (w, x, y, z) in {arm.tip}"
    mass = sum(load.mass for load in arm.attachment.loads)
    yield f"load: {mass:.4g} kg"
    shapes = arm._robot.collisions.items()
    listed = ", ".join(f"{link} {count}" for link, count in shapes) or "none"
    yield _wrapped(f"collision shapes per link: {listed}")
    yield from _lacking(arm)
    for shape in arm.attached:
        yield f"holds: {type(shape).__name__} at {_numbers(shape.position)} m in {arm.tip}"


def _lacking(arm: ArmModel) -> Iterator[str]:
    """Remedies for collision meshes without a file."""
    files = [file for _, file, _ in arm._robot.meshes]
    lost = [file for file in files if find_mesh(file, arm.mesh_folders) is None]
    if lost:
        yield _wrapped(
            f"! {len(lost)} of {len(files)} collision meshes are not where the URDF says, such as "
            f"{lost[0]}: nothing can be checked for collisions until their folder is named "
            "(--mesh-folder; in Python, mesh_folders)"
        )


def _wrapped(text: str) -> str:
    return textwrap.fill(
        text, width=80, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    )


def _numbers(values: np.typing.NDArray[np.float64]) -> str:
    return "(" + ", ".join(_number(value) for value in values) + ")"


def _number(value: float) -> str:
    # Neither -0 nor 1e+04.
    return f"{value + 0.0:.0f}" if abs(value) >= 1000 else f"{value + 0.0:.4g}"


_UNBOUNDED = np.pi  # rad or m, drawn on both sides of a joint without limits
_MAX_NAME = 18  # letters of a joint's name


def panels(arm: ArmModel) -> list[Panel]:
    """The arm seen obliquely, and the ranges of its joints."""
    return [_links(arm), _ranges(arm)]


def _links(arm: ArmModel) -> Panel:
    q = arm._chain.middle
    poses = link_poses(arm, q[None])
    joints = arm._robot.path(arm.base, arm.tip)
    links = [arm._robot.links.index(arm.base)]
    for joint in joints:
        links.append(joint.child if joint.parent == links[-1] else joint.parent)
    at = np.stack([poses[arm._robot.links[link]][1][0] for link in links])
    tip = arm._chain.forward_kinematics(q[None])[0]
    line = on_paper(np.vstack([at, tip]))
    extent = float(np.ptp(line, axis=0).max()) or 1.0
    moving = [i for i, joint in enumerate(joints, 1) if joint.name in arm.joint_names]
    dots = [_dot(line[i], "", palette.AMBER, 3.0) for i in moving]
    axes, names = triad(line.min(axis=0) - [0.3 * extent, 0.0], 0.2 * extent)
    link = Line(line[:, 0], line[:, 1], colour=palette.BLUE, width=4.0)
    ends = [_dot(line[0], "base", palette.GREY, 5.0), _dot(line[-1], "tip", palette.GREEN, 3.0)]
    title = f"{arm._robot.name}, reach at most {arm._chain.reach:.2f} m"
    return Panel(title, [*axes, link], dots=[*names, *dots, *ends], equal=True)


def _ranges(arm: ArmModel) -> Panel:
    rows = []
    for name, low, high in zip(arm.joint_names, arm.limits.lower, arm.limits.upper, strict=True):
        called = name if len(name) <= _MAX_NAME else f"...{name[-_MAX_NAME:]}"
        rows.append((called, _bounded(low, -_UNBOUNDED), _bounded(high, _UNBOUNDED)))
    return bars(rows, title="ranges of the joints", x_label="rad (m)")


def _dot(at: Float64Array, text: str, colour: str, radius: float) -> Dot:
    return Dot(float(at[0]), float(at[1]), text, colour, radius)


def _bounded(limit: float, instead: float) -> float:
    return float(limit) if np.isfinite(limit) else instead


_START = 0.5  # s from rest to the velocity limit
_ONSET = 0.05  # s from rest to full acceleration
_HIGHEST = 5.0  # rad/s^2
_HIGHEST_PRISMATIC = 1.0  # m/s^2
_SLOW = 1.0  # rad/s
_SLOW_PRISMATIC = 0.1  # m/s
_HEAD = """\
# Limits of {robot} from {base} to {tip}, in rad/s, rad/s^2 and rad/s^3
# (m/s, m/s^2 and m/s^3 for prismatic joints). The URDF states the others.
# Assumed values are cautious for most arms; replace them with the maker's where
# these are known.
robot = {name}

[sources]
{velocity}acceleration = "{acceleration}"
jerk = "{jerk}"

[joints]
"""
_ASSUMED = {
    "acceleration": f"assumed: full speed after {_START} s, at most {_HIGHEST:g} rad/s^2 "
    f"({_HIGHEST_PRISMATIC:g} m/s^2); the URDF states none",
    "jerk": f"assumed: full acceleration after {_ONSET} s; the URDF states none",
}


def limits_file(arm: ArmModel) -> str:
    """The text of a limits file for the arm, whose comments state what is assumed."""
    limits = arm.limits
    prismatic = {
        joint.name for joint in arm._robot.path(arm.base, arm.tip) if joint.kind == "prismatic"
    }
    slides = np.array([name in prismatic for name in arm.joint_names])
    assumed = limits.velocity == 0.0
    velocity = np.where(assumed, np.where(slides, _SLOW_PRISMATIC, _SLOW), limits.velocity)
    acceleration = limits.acceleration
    if acceleration is None:
        highest = np.where(slides, _HIGHEST_PRISMATIC, _HIGHEST)
        acceleration = np.minimum(velocity / _START, highest)
    jerk = acceleration / _ONSET if limits.jerk is None else limits.jerk
    head = _HEAD.format(
        robot=arm._robot.name,
        name=_quoted(arm._robot.name),
        base=arm.base,
        tip=arm.tip,
        velocity=_velocity_source([n for n, a in zip(arm.joint_names, assumed, strict=True) if a]),
        acceleration=_source(limits.acceleration, "acceleration"),
        jerk=_source(limits.jerk, "jerk"),
    )
    rows = zip(arm.joint_names, assumed, velocity, acceleration, jerk, strict=True)
    return head + "".join(
        f"{_quoted(name)} = {{ {f'velocity = {speed:.4g}, ' * bool(given)}"
        f"acceleration = {most:.4g}, jerk = {onset:.4g} }}\n"
        for name, given, speed, most, onset in rows
    )


def _velocity_source(assumed: Sequence[str]) -> str:
    """The line that names the joints whose velocity is assumed; empty if there are none."""
    if not assumed:
        return ""
    text = f"assumed: {_SLOW:g} rad/s ({_SLOW_PRISMATIC:g} m/s); the URDF states 0 for "
    return f"velocity = {_quoted(text + ', '.join(assumed))}\n"


def _source(known: Float64Array | None, quantity: str) -> str:
    return _ASSUMED[quantity] if known is None else "as given"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
