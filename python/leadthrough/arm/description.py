"""An arm as text to read."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from leadthrough.arm.meshes import find_mesh

if TYPE_CHECKING:
    from leadthrough import _core
    from leadthrough.arm.arm import Arm

# Quantities, with a heading that is no wider than its numbers, so that 80 columns do.
_COLUMNS = {
    "lower": "lower\nrad (deg)",
    "upper": "upper\nrad (deg)",
    "velocity": "speed\nrad/s",
    "acceleration": "accel.\nrad/s^2",
    "jerk": "jerk\nrad/s^3",
    "effort": "effort\nN m",
}
_WIDEST = 200  # characters; a table is as wide as its joints' names need it to be
_SLIDING = "; prismatic: m instead of rad, N instead of N m"
_INCOMPLETE = """\
The URDF states no acceleration or jerk. A limits file does; complete this one
or let `leadthrough info --write-limits` write one with assumed values:"""


def describe(arm: Arm) -> str:
    """See `Arm.describe`."""
    parts = [_head(arm), _joints(arm), "\n".join(_carried(arm))]
    if arm.limits.acceleration is None or arm.limits.jerk is None:
        parts.append(f"{_INCOMPLETE}\n\n{arm.limits.template().rstrip()}")
    return "\n\n".join(parts) + "\n"


def _head(arm: Arm) -> str:
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


def _joints(arm: Arm) -> str:
    table = Table(box=box.SIMPLE_HEAD, padding=0)
    table.add_column("joint")
    for heading in _COLUMNS.values():
        table.add_column(heading, justify="right")
    for joint in arm._robot.path(arm.base, arm.tip):
        if joint.name in arm.held:
            table.add_row(joint.name, f"held at {arm.held[joint.name]:.4g}")
        elif joint.mimic is not None:
            table.add_row(joint.name, _mimicry(joint.mimic))
        elif joint.kind != "fixed":
            kind = "" if joint.kind == "revolute" else f" {joint.kind}"
            table.add_row(joint.name + kind, *_limits(arm, joint))
    return _rendered(table)


def _mimicry(mimic: _core.Mimic) -> str:
    return f"= {mimic.multiplier:.4g} {mimic.joint} {mimic.offset:+.4g}"


def _limits(arm: Arm, joint: _core.Joint) -> Iterator[str]:
    i = arm.joint_names.index(joint.name)
    for name in _COLUMNS:
        column = getattr(arm.limits, name)
        if column is None:
            yield "unknown"
        elif not np.isfinite(column[i]):
            yield "none"
        else:
            yield _number(column[i]) + _unit(name, joint, float(column[i]))


def _unit(name: str, joint: _core.Joint, value: float) -> str:
    """The same value in degrees for a limit of an angle; the unit for a limit of a length."""
    if name not in ("lower", "upper"):
        return ""
    return " m" if joint.kind == "prismatic" else f" ({np.degrees(value):.4g})"


def _carried(arm: Arm) -> Iterator[str]:
    outside = set(arm.held) - {joint.name for joint in arm._robot.path(arm.base, arm.tip)}
    if outside:
        yield "also held: " + ", ".join(
            f"{name} at {arm.held[name]:.4g}" for name in sorted(outside)
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


def _lacking(arm: Arm) -> Iterator[str]:
    """What to do about collision meshes whose files are not there."""
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


def _rendered(table: Table) -> str:
    text = io.StringIO()
    Console(file=text, width=_WIDEST, color_system=None).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()).strip("\n")
