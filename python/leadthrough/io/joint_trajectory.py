"""Joint trajectories in the layout of ROS 2's trajectory_msgs/JointTrajectory, as JSON and YAML.

Files suit ros2_control's joint trajectory controller: the arm waits at the first configuration and
moves on. The controller wants every point after time 0, so that the first sample is due one
sampling step after the start, and all others as much later. First and last velocities, below
1e-3 rad/s, are written as zero. Events stand under the key "events", which is no part of the ROS
message: each has a `name` and, like the points, a `time_from_start`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NotRequired, TypedDict

import numpy as np

import leadthrough._core as core
from leadthrough import check, sanity
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io import files, headers
from leadthrough.io.files import ReadLimits, StrPath
from leadthrough.io.headers import JOINT_SUFFIXES, Columns
from leadthrough.io.table import ArrayTable
from leadthrough.motion import Event, JointTrajectory

# rad/s, m/s: slower than this is rest; the controller wants a velocity of exactly zero.
REST_VELOCITY = 1e-3

_BLOCK = 2**20  # bytes
_MAX_BEHIND = 2**24  # bytes behind the points, of events
_FORMAT = "trajectory_msgs/JointTrajectory"
_DAMAGE = (
    ValueError,
    TypeError,
    KeyError,
    IndexError,
    AttributeError,
    OverflowError,
    RecursionError,
)
NANOSECONDS = 1_000_000_000  # per second


class Stamp(TypedDict):
    """A time or duration as ROS 2 messages have it; `nanosec` is below 10**9."""

    sec: int
    nanosec: int


class Point(TypedDict):
    """A trajectory_msgs/JointTrajectoryPoint, with a number per joint or none at all."""

    positions: list[float]
    velocities: list[float]
    accelerations: list[float]
    effort: list[float]
    time_from_start: Stamp


class Message(TypedDict):
    """A trajectory_msgs/JointTrajectory, with the events where there are some."""

    header: Mapping[str, object]  # a std_msgs/Header
    joint_names: list[str]
    points: list[Point]
    events: NotRequired[list[dict[str, object]]]  # each with a name, timed as the points are


@dataclass(frozen=True)
class _Form:
    """How points stand in a document, which is read and written in blocks."""

    begin: str  # before the first
    point: tuple[str, ...]  # texts around positions, velocities, accelerations, sec and nanosec
    between: str
    end: str  # behind the last
    parse: Callable[[str], Any]  # Any: whatever a document holds

    def layout(self, groups: int, joints: int) -> core.RecordLayout:
        """The text of a point with positions and velocities alone, or with accelerations too."""
        texts = [self.between + self.point[0], *self.point[1:]]
        if groups < len(JOINT_SUFFIXES):
            texts[2:4] = ["".join(texts[2:4])]
        return core.RecordLayout(texts, [*[joints] * groups, 1, 1], ", ", 2)

    def written(self, trajectory: JointTrajectory) -> Iterator[str]:
        """The points in blocks of text."""
        due = np.array(due_nanoseconds(trajectory.times))
        groups = [trajectory.positions, resting_at_both_ends(trajectory.velocities)]
        if trajectory.accelerations is not None:
            groups.append(trajectory.accelerations)
        rows = np.column_stack([*groups, due // NANOSECONDS, due % NANOSECONDS])
        layout = self.layout(len(groups), trajectory.positions.shape[1])
        blocks = files.written_blocks(rows, layout)
        yield self.begin + next(blocks).removeprefix(self.between)
        yield from blocks
        yield self.end

    def read(self, path: Path, limits: ReadLimits) -> ArrayTable | None:
        """The trajectory of a file in this form; None for another one."""
        limits.streamed(path)
        with path.open("rb") as file:
            head, begin, rest = file.read(_BLOCK).partition(self.begin.encode())
            joints = rest.partition(b"]")[0].count(b",") + 1
            rest = self.between.encode() + rest
            for groups in (3, 2):
                layout = self.layout(groups, joints)
                if core.read_records(rest, layout)[1]:
                    break
            else:
                return None
            blocks = list[Float64Array]()
            while rest:
                values, length = core.read_records(rest, layout)
                limits.numbers(len(values), "the points")
                blocks.append(values)
                more = file.read(_BLOCK)
                rest = rest[length:] + more
                if not more or len(rest) > _MAX_BEHIND:
                    break
        if not rest.startswith(self.end.encode()) or len(rest) > _MAX_BEHIND:
            return None
        frame = self.parse((head + begin + rest).decode("utf-8-sig"))
        rows = np.concatenate(blocks).reshape(-1, groups * joints + 2)
        if frame["points"] or len(frame["joint_names"]) != joints:
            return None
        quantities_of = dict(zip(JOINT_SUFFIXES, np.hsplit(rows[:, :-2], groups), strict=False))
        seconds, nanoseconds = rows[:, -2:].astype(np.int64).T
        return _columns(frame, quantities_of, (seconds * NANOSECONDS + nanoseconds) / NANOSECONDS)


_JSON = _Form(
    '"points": [',
    (
        '{"positions": [',
        '], "velocities": [',
        '], "accelerations": [',
        '], "effort": [], "time_from_start": {"sec": ',
        ', "nanosec": ',
        "}}",
    ),
    ", ",
    "]",
    json.loads,
)
_YAML = _Form(
    "points:\n",
    (
        "- positions: [",
        "]\n  velocities: [",
        "]\n  accelerations: [",
        ']\n  effort: []\n  time_from_start: {"sec": ',
        ', "nanosec": ',
        "}\n",
    ),
    "",
    "",
    files.parsed_yaml,
)


def message(trajectory: JointTrajectory) -> Message:
    """The trajectory as a message."""
    content = _frame(trajectory)
    content["points"] = _points(trajectory)
    return content


def _frame(trajectory: JointTrajectory) -> Message:
    """The message without its points."""
    names = list(checked_joint_names(trajectory))
    warn_of_units(names)
    content: Message = {
        "header": {"stamp": to_stamp(0), "frame_id": ""},
        "joint_names": names,
        "points": [],
    }
    if trajectory.events:
        content["events"] = _events(trajectory)
    return content


def write_json(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes the message as JSON."""
    empty = _JSON.begin + _JSON.end
    head, _, tail = json.dumps(_frame(trajectory), allow_nan=False).partition(empty)
    _write(chain([head], _JSON.written(trajectory), [tail, "\n"]), path)


def write_yaml(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes the message as YAML, for `ros2 topic pub --yaml-file`."""
    frame = _frame(trajectory)
    head = (
        f"header: {json.dumps(frame['header'])}\n"
        f"joint_names: {json.dumps(frame['joint_names'], ensure_ascii=False)}\n"
    )
    events = [f"- {json.dumps(each, ensure_ascii=False)}\n" for each in frame.get("events", [])]
    _write(chain([head], _YAML.written(trajectory), ["events:\n", *events] if events else []), path)


def table_of_json(path: Path) -> ArrayTable:
    """The trajectory in a JSON file, timed from the controller's time 0 on."""
    limits = ReadLimits()
    with files.refusing_damage(_FORMAT, damage=_DAMAGE):
        if found := _JSON.read(path, limits):
            return found
        text = files.read_text(path, limits)
        limits.items(sum(map(text.count, "[{:,")), "the values")
        return table(json.loads(text))


def table_of_yaml(path: Path) -> ArrayTable:
    """The trajectory in a YAML file, timed from the controller's time 0 on."""
    with files.refusing_damage(_FORMAT, damage=_DAMAGE):
        return _YAML.read(path, ReadLimits()) or table(files.load_yaml(path))


def table(content: Any) -> ArrayTable:  # Any: whatever a file holds; reading it is the check
    """The columns of a message."""
    if not isinstance(content, dict) or not {"joint_names", "points"} <= content.keys():
        raise InvalidInput(f"not a readable {_FORMAT} ('joint_names' or 'points' is missing)")
    joints, points = content["joint_names"], content["points"]
    names = _names(joints, len(points))
    values = {}
    for quantity in JOINT_SUFFIXES:
        rows = [point.get(quantity) or [] for point in points]
        if quantity == "positions" or any(rows):
            values[quantity] = _matrix(rows, quantity, len(names))
    times = np.array([_seconds(point["time_from_start"]) for point in points])
    return _columns(content, values, times)


def _names(joints: Iterable[object], points: int) -> Columns:
    """The joints of a message of so many points."""
    names = tuple(str(name) for name in joints)
    if not names or len(set(names)) != len(names) or not points:
        raise InvalidInput("expected different joint_names and at least one point")
    return names


def _columns(content: Any, values: Mapping[str, Float64Array], times: Float64Array) -> ArrayTable:
    """The columns of a message whose points are arrays already."""
    names = _names(content["joint_names"], len(times))
    columns = {"time_from_start": times, **joint_columns(names, values)}
    timed_events = tuple(
        Event(_seconds(each["time_from_start"]), each["name"])
        for each in content.get("events") or []
    )
    roles = {"time": ("time_from_start",), "joints": names}
    return ArrayTable(columns, roles=roles, angles="radians", events=timed_events)


def _write(parts: Iterable[str], path: StrPath) -> None:
    with files.replacing(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.writelines(parts)


def _seconds(due: Any) -> float:  # Any: whatever a file holds
    """A time of ROS 2 or of ROS 1, or a number of seconds."""
    if isinstance(due, int | float):
        return check.number(due, "time_from_start")
    parts = ("sec", "nanosec") if "sec" in due else ("secs", "nsecs")
    whole = (check.integer(due[part], part, at_least=-(2**63)) for part in parts)
    return stamp_nanoseconds(*whole) / NANOSECONDS


def _matrix(rows: Sequence[object], quantity: str, width: int) -> Float64Array:
    for i, row in enumerate(rows):
        if not isinstance(row, list) or len(row) != width:
            raise InvalidInput(f"{quantity}: expected {width} numbers, one per joint, at point {i}")
        for value in row:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InvalidInput(f"{quantity}: expected numbers, got {value!r} at point {i}")
    return np.array(rows, dtype=np.float64).reshape(len(rows), width)


def _points(trajectory: JointTrajectory) -> list[Point]:
    times = due_nanoseconds(trajectory.times)
    velocities = resting_at_both_ends(trajectory.velocities)
    accelerations = trajectory.accelerations
    return [
        {
            "positions": trajectory.positions[i].tolist(),
            "velocities": velocities[i].tolist(),
            "accelerations": [] if accelerations is None else accelerations[i].tolist(),
            "effort": [],
            "time_from_start": to_stamp(time),
        }
        for i, time in enumerate(times)
    ]


def _events(trajectory: JointTrajectory) -> list[dict[str, object]]:
    times = trajectory.times
    return [
        {"name": each.name, "time_from_start": to_stamp(_from_start(each.time, times))}
        for each in trajectory.events
    ]


def _from_start(time: float, times: Float64Array) -> int:
    """When a time of the motion is due, in ns: its first sample one step after the start."""
    return round(float(time - times[0] + (times[1] - times[0])) * NANOSECONDS)


def due_nanoseconds(times: Float64Array) -> list[int]:
    """When samples are due from the start on, the first one step after it, ns."""
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
    """The velocities with exactly zero at both ends, where they are almost."""
    if velocities is None:
        raise InvalidInput(
            "trajectory: expected velocities, got none; `leadthrough retime` adds them, "
            "in Python timing.retime"
        )
    for i, which in ((0, "first"), (-1, "last")):
        fastest = float(np.abs(velocities[i]).max())
        if fastest > REST_VELOCITY:
            raise InvalidInput(
                f"trajectory: expected rest at the {which} sample, got {fastest:.6g} rad/s; "
                "`leadthrough retime` brings the ends to rest, in Python timing.retime"
            )
    result = velocities.copy()
    result[[0, -1]] = 0.0
    return result


def checked_joint_names(trajectory: JointTrajectory) -> Columns:
    """The joints' names."""
    check.instance(trajectory, "trajectory", JointTrajectory)
    names = trajectory.joint_names
    if not names:
        raise InvalidInput(
            "trajectory: expected joint_names, which the robot needs, got none; "
            "`leadthrough plan --robot` writes them, "
            "in Python JointTrajectory(..., joint_names=arm.joint_names)"
        )
    if len(set(names)) != len(names) or not all(name and name.isprintable() for name in names):
        raise check.refused("trajectory", "different, printable joint_names", list(names))
    return names


def warn_of_units(names: Iterable[str]) -> None:
    """Warns of joints whose names end in a unit, in which a reader takes their numbers."""
    if stated := [name for name in names if headers.unit(name, "joints")[1] is not None]:
        sanity.warn(
            f"motion: joints {', '.join(stated)} are written in rad (m), and their names state "
            "units, in which they are read; rename them"
        )


def quantities(trajectory: JointTrajectory) -> dict[str, Float64Array]:
    """The positions, velocities and accelerations (n, joints) that a trajectory has, by name."""
    warn_of_units(trajectory.joint_names or ())
    found = {name: getattr(trajectory, name) for name in JOINT_SUFFIXES}
    return {name: values for name, values in found.items() if values is not None}


def joint_columns(joints: Columns, values: Mapping[str, Float64Array]) -> dict[str, Float64Array]:
    """A column (n,) for each quantity of each joint, named as `headers.derivatives` finds it."""
    return {
        name + JOINT_SUFFIXES[quantity]: array[:, i]
        for quantity, array in values.items()
        for i, name in enumerate(joints)
    }


def to_stamp(nanoseconds: int) -> Stamp:
    """The stamp of a time in ns."""
    sec, nanosec = divmod(nanoseconds, NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def stamp_nanoseconds(sec: int, nanosec: int) -> int:
    """The time of a stamp in ns; its parts may be any kind of integer."""
    return int(sec) * NANOSECONDS + int(nanosec)
