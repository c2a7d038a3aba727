"""Joint trajectories as programs for the arms of Universal Robots.

Source: Universal Robots, "The URScript Programming Language", movej and servoj.
"""

from __future__ import annotations

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.io.joint_columns import checked_joint_names
from leadthrough.io.rate import at_rate
from leadthrough.motion import JointTrajectory

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


def write(
    trajectory: JointTrajectory,
    path: StrPath,
    *,
    rate: float = 125.0,
    lookahead: float = 0.1,
    gain: float = 300.0,
    name: str = "leadthrough",
) -> None:
    """Writes a program: movej to the first configuration, servoj along the rest, stopj."""
    hertz = check.number(rate, "rate", at_least=1.0, at_most=500.0)
    ahead = check.number(lookahead, "lookahead", at_least=0.03, at_most=0.2)
    stiffness = check.number(gain, "gain", at_least=100.0, at_most=2000.0)
    if not isinstance(name, str) or not name.isidentifier() or not name.isascii():
        raise InvalidInput(f"name: expected ASCII letters, digits and underscores, got {name!r}")
    order = _order(checked_joint_names(trajectory))
    times, positions, _ = at_rate(trajectory, hertz)
    ending = f"0, 0, {1.0 / hertz!r}, {ahead!r}, {stiffness!r})"
    lines = [
        f"def {name}():",
        f"  movej({_row(positions[0, order])}, a=0.5, v=0.5)",
        *_steps(trajectory, times, [f"  servoj({_row(row[order])}, {ending}" for row in positions]),
        "  stopj(1.0)",
        "end",
    ]
    with replacing(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii")


def _steps(trajectory: JointTrajectory, times: Float64Array, moves: list[str]) -> list[str]:
    """The moves after the first, each preceded by the messages of events due before it."""
    due = [
        (int(np.searchsorted(times, event.time - trajectory.times[0])), event.name)
        for event in trajectory.events
    ]
    lines: list[str] = []
    for i, move in enumerate(moves):
        if i > 0:
            lines.append(move)
        lines += [f"  textmsg({_quoted(name)})" for at, name in due if at == i]
    return lines


def _quoted(name: str) -> str:
    plain = name.encode("ascii", "replace").decode().replace('"', "'")
    return '"' + "".join(each if each.isprintable() else " " for each in plain) + '"'


def _order(names: tuple[str, ...]) -> list[int]:
    found = [[i for i, name in enumerate(names) if name.endswith(joint)] for joint in JOINTS]
    if len(names) != len(JOINTS) or any(len(each) != 1 for each in found):
        raise InvalidInput(
            f"trajectory: expected the joints of a UR arm, {', '.join(JOINTS)}; "
            f"got {', '.join(names)}"
        )
    return [each[0] for each in found]


def _row(values: Float64Array) -> str:
    return "[" + ", ".join(f"{value:.10f}" for value in values) + "]"
