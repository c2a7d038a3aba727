"""Joint trajectories as a URScript program and as commands for the 1 kHz loop of a Franka arm.

Franka's table names its columns as libfranka's logs do: `time` in s from 0 on, `q_d[0]` to `q_d[6]`
in rad and `dq_d[0]` to `dq_d[6]` in rad/s, a row for each cycle, a comment for each event.
Source: Universal Robots, "The URScript Programming Language", movej and servoj.
"""

from __future__ import annotations

import math

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io.csv import write_rows
from leadthrough.io.files import StrPath, replacing
from leadthrough.io.joint_trajectory import checked_joint_names, resting_at_both_ends
from leadthrough.motion import JointTrajectory, moved_events

UR_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
FRANKA_RATE = 1000.0  # Hz
FRANKA_JOINTS = 7
_MAX_SAMPLES = 10_000_000  # samples in a file; three hours at 1 kHz


def write_urscript(
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
    times, positions, _ = _at_rate(trajectory, hertz)
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
    found = [[i for i, name in enumerate(names) if name.endswith(joint)] for joint in UR_JOINTS]
    if len(names) != len(UR_JOINTS) or any(len(each) != 1 for each in found):
        raise InvalidInput(
            f"trajectory: expected the joints of a UR arm, {', '.join(UR_JOINTS)}; "
            f"got {', '.join(names)}"
        )
    return [each[0] for each in found]


def _row(values: Float64Array) -> str:
    return "[" + ", ".join(f"{value:.10f}" for value in values) + "]"


def write_franka(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes a row for each millisecond, to the last digit."""
    names = checked_joint_names(trajectory)
    order = sorted(range(len(names)), key=lambda i: names[i][-1])
    if [names[i][-1] for i in order] != list("1234567"):
        raise InvalidInput(
            f"trajectory: expected {FRANKA_JOINTS} joints whose names end in 1 to {FRANKA_JOINTS}, "
            f"got {', '.join(names)}"
        )
    times, positions, velocities = _at_rate(trajectory, FRANKA_RATE)
    header = [f"{part}[{i}]" for part in ("q_d", "dq_d") for i in range(FRANKA_JOINTS)]
    rows = np.column_stack([times, positions[:, order], velocities[:, order]])
    own = trajectory.times - trajectory.times[0]
    due_events = moved_events(trajectory.events, trajectory.times, own)
    write_rows(path, ["time", *header], rows, due_events)


def _at_rate(
    trajectory: JointTrajectory, rate: float
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Evenly spaced samples of a trajectory, on cubic Hermite curves through its own."""
    velocities = resting_at_both_ends(trajectory.velocities)
    if len(trajectory.times) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    if trajectory.duration * rate > _MAX_SAMPLES:
        raise InvalidInput(
            f"trajectory: expected at most {_MAX_SAMPLES:,} samples at {rate:g} Hz, "
            f"got a duration of {trajectory.duration:.6g} s"
        )
    own = trajectory.times - trajectory.times[0]
    # A duration within a millionth of a step of whole steps needs no further step.
    times = np.arange(math.ceil(trajectory.duration * rate - 1e-6) + 1) / rate
    if len(own) == len(times) and np.allclose(own, times, rtol=0.0, atol=1e-6 / rate):
        return times, trajectory.positions, velocities
    return times, *_interpolated(trajectory, velocities, np.minimum(times, own[-1]))


def _interpolated(
    trajectory: JointTrajectory, velocities: Float64Array, times: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Positions and velocities at times (n,) from the trajectory's start, at rest at the end."""
    from scipy.interpolate import CubicHermiteSpline

    own = trajectory.times - trajectory.times[0]
    curve = CubicHermiteSpline(own, trajectory.positions, velocities)
    positions, speeds = np.asarray(curve(times)), np.asarray(curve(times, 1))
    positions[-1], speeds[-1] = trajectory.positions[-1], 0.0
    return positions, speeds
