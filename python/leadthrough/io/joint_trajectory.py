"""Joint trajectories in the layout of ROS 2's trajectory_msgs/JointTrajectory, JSON and YAML.

Such as ros2_control's joint trajectory controller takes it: the arm stands at the first
configuration and goes on. As the controller wants every point after time 0, the first sample is
due one sampling step after the start, and all others as much later. First and last velocities,
below 1e-3 rad/s, are written as zero. Where there are events, they stand under the key "events",
which is no part of the ROS message: each has a `name` and, like the points, a `time_from_start`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event
from leadthrough.io import bounds
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.io.joint_names import checked_joint_names
from leadthrough.io.table import ArrayTable
from leadthrough.motion import JointTrajectory

# rad/s, m/s: slower than this is standing; the controller wants a velocity of exactly zero.
REST_VELOCITY = 1e-3

_NANOSECONDS = 1_000_000_000
_SUFFIXES = {"positions": "", "velocities": "_velocity", "accelerations": "_acceleration"}
_DEEPEST = 16  # collections in collections; deep ones make PyYAML's compiled loader crash
_DEEP_BLOCK = re.compile(r"^[ ?:-]{64}", re.MULTILINE)
# A list that mentions itself a few times over can stand for billions of numbers.
_ANCHOR_AND_ALIAS = [
    re.compile(rf"(?:^|[\s\[{{,:-]){mark}\S", re.MULTILINE) for mark in ("&", r"\*")
]
# 1e-05 is a text in YAML, 1.0e-05 a number.
_EXPONENT = re.compile(r"(?<![.\d])(\d)e(?=[-+])")
_DAMAGE = (
    ValueError,
    TypeError,
    KeyError,
    IndexError,
    AttributeError,
    OverflowError,
    RecursionError,
)


def message(trajectory: JointTrajectory) -> dict[str, Any]:
    """The trajectory as a message.

    Raises InvalidInput for joints without different, printable names, fewer than two samples, no
    velocities (`leadthrough.timing.differentiate` adds them), a motion that does not start and
    end at rest and samples less than a nanosecond apart.
    """
    content = {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(checked_joint_names(trajectory)),
        "points": _points(trajectory),
    }
    if trajectory.events:
        content["events"] = _events(trajectory)
    return content


def write_json(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes the message as JSON. Raises InvalidInput as `message` does, and for the path."""
    text = json.dumps(message(trajectory), allow_nan=False)
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def write_yaml(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes the message as YAML, for `ros2 topic pub --yaml-file`.

    Raises InvalidInput as `message` does, and for the path.
    """
    content = message(trajectory)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.writelines(_yaml(content))


def table_of_json(path: Path) -> ArrayTable:
    """The trajectory in a file, from the controller's time 0 on. Raises InvalidInput."""
    text = bounds.text(path)
    try:
        return table(json.loads(text))
    except _DAMAGE as error:
        raise _no_trajectory(error) from None


def table_of_yaml(path: Path) -> ArrayTable:
    """The same of YAML. Raises InvalidInput."""
    text = bounds.text(path)
    try:
        _check_harmless(text)
        return table(yaml.load(text, Loader=_Loader))
    except (yaml.YAMLError, *_DAMAGE) as error:
        raise _no_trajectory(error) from None


def table(content: Any) -> ArrayTable:
    """The columns of a message. Raises InvalidInput, or what a wrong layout leads to."""
    names = tuple(str(name) for name in content["joint_names"])
    points = content["points"]
    if not names or len(set(names)) != len(names) or not points:
        raise InvalidInput("expected different joint_names and at least one point")
    columns = {"time_from_start": np.array([_seconds(p["time_from_start"]) for p in points])}
    for part, suffix in _SUFFIXES.items():
        rows = [point.get(part) or [] for point in points]
        if part == "positions" or any(rows):
            values = _matrix(rows, part, len(names))
            columns |= {name + suffix: values[:, i] for i, name in enumerate(names)}
    happened = tuple(
        Event(_seconds(each["time_from_start"]), each["name"])
        for each in content.get("events") or []
    )
    roles = {"time": ("time_from_start",), "joints": names}
    return ArrayTable(columns, roles, angles="radians", events=happened)


def _check_harmless(text: str) -> None:
    """Refuses YAML that nests deep, or that stands for more than it says."""
    if all(mark.search(text) for mark in _ANCHOR_AND_ALIAS):
        raise InvalidInput("expected YAML without aliases")
    steps = [1 if bracket[0] in "[{" else -1 for bracket in re.finditer(r"[\[\]{}]", text)]
    if _DEEP_BLOCK.search(text) or max(accumulate(steps), default=0) > _DEEPEST:
        raise InvalidInput(f"expected YAML that nests at most {_DEEPEST} deep")


def _yaml(content: dict[str, Any]) -> Iterator[str]:
    """The lines of a message; PyYAML's own writer takes ten times as long."""
    yield f"header: {json.dumps(content['header'])}\n"
    yield f"joint_names: {json.dumps(content['joint_names'], ensure_ascii=False)}\n"
    yield "points:\n"
    for point in content["points"]:
        for i, (name, value) in enumerate(point.items()):
            numbers = _EXPONENT.sub(r"\1.0e", json.dumps(value))
            yield f"{'  ' if i else '- '}{name}: {numbers}\n"
    if "events" in content:
        yield "events:\n"
        for event in content["events"]:
            yield f"- {json.dumps(event, ensure_ascii=False)}\n"


_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def _no_trajectory(error: Exception) -> InvalidInput:
    if isinstance(error, InvalidInput):
        return error
    what = " ".join(str(error).split())[:200]
    return InvalidInput(f"expected a trajectory_msgs/JointTrajectory ({what})")


def _seconds(stamp: Any) -> float:
    return (int(stamp["sec"]) * _NANOSECONDS + int(stamp["nanosec"])) / _NANOSECONDS


def _matrix(rows: list[Any], part: str, width: int) -> Float64Array:
    if not all(isinstance(row, list) and len(row) == width for row in rows):
        raise InvalidInput(f"{part}: expected {width} numbers in each point, as there are joints")
    for row in rows:
        for value in row:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InvalidInput(f"{part}: expected numbers, got {value!r}")
    return np.array(rows, dtype=np.float64).reshape(len(rows), width)


def _points(trajectory: JointTrajectory) -> list[dict[str, Any]]:
    times = nanoseconds(trajectory.times)
    velocities = resting_at_both_ends(trajectory.velocities)
    accelerations = trajectory.accelerations
    return [
        {
            "positions": trajectory.positions[i].tolist(),
            "velocities": velocities[i].tolist(),
            "accelerations": [] if accelerations is None else accelerations[i].tolist(),
            "effort": [],
            "time_from_start": _stamp(time),
        }
        for i, time in enumerate(times)
    ]


def _events(trajectory: JointTrajectory) -> list[dict[str, Any]]:
    return [
        {
            "name": event.name,
            "time_from_start": _stamp(_from_start(event.time, trajectory.times)),
        }
        for event in trajectory.events
    ]


def _stamp(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // _NANOSECONDS, "nanosec": nanoseconds % _NANOSECONDS}


def _from_start(time: float, times: Float64Array) -> int:
    """When a time of the motion is due, in ns: its first sample a step after the start."""
    return round(float(time - times[0] + (times[1] - times[0])) * _NANOSECONDS)


def nanoseconds(times: Float64Array) -> list[int]:
    """Times from the start, the first one step after it, ns. Raises InvalidInput."""
    if len(times) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    if times[-1] - times[0] + (times[1] - times[0]) >= 2**31:
        raise InvalidInput(
            f"trajectory: expected a duration below 2**31 s, got {times[-1] - times[0]:.6g} s"
        )
    rounded = [_from_start(time, times) for time in times]
    if (np.diff([0, *rounded]) <= 0).any():
        raise InvalidInput("trajectory: expected samples at least a nanosecond apart")
    return rounded


def resting_at_both_ends(velocities: Float64Array | None) -> Float64Array:
    """The velocities with exactly zero at both ends, if they are almost. Raises InvalidInput."""
    if velocities is None:
        raise InvalidInput(
            "trajectory: expected velocities, got none; timing.differentiate adds them"
        )
    for i, which in ((0, "first"), (-1, "last")):
        fastest = float(np.abs(velocities[i]).max())
        if fastest > REST_VELOCITY:
            raise InvalidInput(
                f"trajectory: expected rest at the {which} sample, got {fastest:.6g} rad/s; "
                "timing.differentiate brings the ends to rest"
            )
    result = velocities.copy()
    result[[0, -1]] = 0.0
    return result
