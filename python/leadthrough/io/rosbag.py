"""ROS bags, by rosbags (extra `ros`) and without ROS: ROS 1, and ROS 2 with SQLite or MCAP.

JointState, JointTrajectory, PoseStamped and, for named frames, transforms are read. Times are those
of the messages' headers, or of the bag where these are zero, counted from the first message. Text
messages on `/events` become events.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import optional
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event, Events
from leadthrough.io import bounds, joint_states, joint_trajectory, stamps
from leadthrough.io.headers import JOINT_SUFFIXES
from leadthrough.io.request import Request
from leadthrough.io.stamps import NANOSECONDS
from leadthrough.io.table import ArrayTable

EVENTS_TOPIC = "/events"  # one String message per event

# The bag's time in ns and the message. Any: classes that rosbags makes at run time.
Messages = list[tuple[int, Any]]

_JOINTS = "sensor_msgs/msg/JointState"
_TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
_POSE = "geometry_msgs/msg/PoseStamped"
_TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
_TEXT = "std_msgs/msg/String"
# Source: the MCAP specification: magic, then records of a kind, a length and a content; that of a
# chunk begins with two times and its size when inflated.
_MCAP_MAGIC = 8
_MCAP_RECORD = struct.Struct("<BQ")
_MCAP_CHUNK_KIND = 6
_MCAP_CHUNK = struct.Struct("<16xQ")
_ITEMS_PER_MESSAGE = 16  # objects that a message becomes


def tables(path: Path, request: Request) -> list[ArrayTable]:
    """The motions on the topic asked for, or on the only one that fits."""
    with _opened(path) as bag:
        topic, kind = _chosen(bag, request)
        messages = _messages(bag, topic)
        if not messages:
            raise InvalidInput(f"topic: {topic} has no messages")
        found = _TABLES[kind](messages, request)
        return [replace(table, events=_events(bag, messages[0][0], table)) for table in found]


def topics(path: Path) -> dict[str, str]:
    """The type of the messages of each topic."""
    with _opened(path) as bag:
        return _kinds(bag)


def motions(topics: Mapping[str, str]) -> list[str]:
    """The topics that have motions and need no named frames."""
    return [name for name, kind in topics.items() if kind in _MOTIONS]


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    highlevel = optional.load("rosbags.highlevel", extra="ros")
    store = humble_types()
    with bounds.reading("ROS bag"):
        for file in path.glob("*.mcap") if path.is_dir() else [path]:
            if file.suffix.lower() == ".mcap":
                _check_chunks(file)
        with highlevel.AnyReader([path], default_typestore=store) as bag:
            yield bag


def humble_types() -> Any:  # Any: rosbags is optional
    """The message types of ROS 2 Humble; older SQLite bags don't carry their own."""
    typesys = optional.load("rosbags.typesys", extra="ros")
    return typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)


def _check_chunks(path: Path) -> None:
    """Refuses an MCAP file with a chunk that claims to inflate beyond the bounds."""
    size = path.stat().st_size
    at = _MCAP_MAGIC
    with path.open("rb") as file:
        while at + _MCAP_RECORD.size <= size:
            file.seek(at)
            kind, length = _MCAP_RECORD.unpack(file.read(_MCAP_RECORD.size))
            head = file.read(_MCAP_CHUNK.size) if kind == _MCAP_CHUNK_KIND else b""
            if len(head) == _MCAP_CHUNK.size:
                bounds.Gate().bytes(_MCAP_CHUNK.unpack(head)[0], "a chunk")
            at += _MCAP_RECORD.size + length


def _chosen(bag: Any, request: Request) -> tuple[str, str]:
    """The topic to read and the type of its messages."""
    topics = _kinds(bag)
    if request.topic is not None:
        kind = topics.get(request.topic, "")
        if kind not in _TABLES:
            what = f"{request.topic} has no motion" if kind else f"there is no {request.topic}"
            raise InvalidInput(f"topic: {what}; topics with motions: {_listed(topics)}")
        return request.topic, kind
    fitting = {name: kind for name, kind in topics.items() if kind in _wanted(request)}
    if len(fitting) == 1:
        return next(iter(fitting.items()))
    what = "several topics fit" if fitting else "no topic fits"
    raise InvalidInput(f"topic: {what}; name one, topics with motions: {_listed(topics)}")


def _kinds(bag: Any) -> dict[str, str]:
    return {name: str(info.msgtype) for name, info in bag.topics.items()}


def _listed(topics: Mapping[str, str]) -> str:
    return (
        ", ".join(
            f"{name} ({kind.split('/')[-1]}{', needs frames' if kind in _TRANSFORMS else ''})"
            for name, kind in topics.items()
            if kind in _TABLES
        )
        or "none"
    )


def _wanted(request: Request) -> Sequence[str]:
    if request.frames is not None:
        return _TRANSFORMS
    if "joints" in request.columns:
        return (_JOINTS, _TRAJECTORY)
    return (_POSE,) if request.columns.keys() & {"positions", "orientations"} else _MOTIONS


def _messages(bag: Any, topic: str) -> Messages:
    connections = [each for each in bag.connections if each.topic == topic]
    found: Messages = []
    gate = bounds.Gate()
    for connection, time, data in bag.messages(connections=connections):
        gate.items(_ITEMS_PER_MESSAGE, topic)
        gate.bytes(len(data), topic)
        found.append((time, bag.deserialize(data, connection.msgtype)))
    return found


def _events(bag: Any, start: int, table: ArrayTable) -> Events:
    """The events on the table's clock; its first sample came at `start`, ns on the bag's clock."""
    info = bag.topics.get(EVENTS_TOPIC)
    if info is None or info.msgtype != _TEXT:
        return ()
    first = float(table.numbers(table.roles["time"][0])[0])
    return tuple(
        Event(first + (time - start) / NANOSECONDS, message.data)
        for time, message in _messages(bag, EVENTS_TOPIC)
    )


def _joint_states(messages: Messages, request: Request) -> list[ArrayTable]:
    stamps = _times([(time, message.header.stamp) for time, message in messages])
    states = [message for _, message in messages]
    return [joint_states.table(stamps, states, request.columns.get("joints"))]


def _trajectories(messages: Messages, _: Request) -> list[ArrayTable]:
    return [
        joint_trajectory.table(
            {
                "joint_names": message.joint_names,
                "points": [_point(point) for point in message.points],
            }
        )
        for _, message in messages
    ]


def _point(point: Any) -> dict[str, Any]:
    due = point.time_from_start
    values = {quantity: getattr(point, quantity).tolist() for quantity in JOINT_SUFFIXES}
    return {"time_from_start": {"sec": due.sec, "nanosec": due.nanosec}, **values}


def _poses(messages: Messages, _: Request) -> list[ArrayTable]:
    frames = {message.header.frame_id for _, message in messages}
    if len(frames) > 1:
        raise InvalidInput(f"topic: expected poses in one frame, got {', '.join(sorted(frames))}")
    times = _times([(time, message.header.stamp) for time, message in messages])
    return [_pose_table(times, [(m.pose.position, m.pose.orientation) for _, m in messages])]


def _transforms(messages: Messages, request: Request) -> list[ArrayTable]:
    every = [(time, each) for time, message in messages for each in message.transforms]
    edges = sorted({(each.header.frame_id, each.child_frame_id) for _, each in every})
    if request.frames not in edges:
        listed = ", ".join(f"({parent!r}, {child!r})" for parent, child in edges)
        raise InvalidInput(f"frames: expected one of {listed}, got {request.frames}")
    ours = [
        (time, each)
        for time, each in every
        if (each.header.frame_id, each.child_frame_id) == request.frames
    ]
    times = _times([(time, each.header.stamp) for time, each in ours])
    return [_pose_table(times, [(t.transform.translation, t.transform.rotation) for _, t in ours])]


def _pose_table(times: Float64Array, poses: list[tuple[Any, Any]]) -> ArrayTable:
    positions = np.array([(p.x, p.y, p.z) for p, _ in poses])
    orientations = np.array([(q.w, q.x, q.y, q.z) for _, q in poses])
    arrays = {"time": times, "positions": positions, "orientations_wxyz": orientations}
    return ArrayTable(arrays, roles={"time": ("time",)})


def _times(stamped: list[tuple[int, Any]]) -> Float64Array:
    """Seconds (n,) since the first of the headers' stamps, or of the bag's times."""
    headers = [stamps.nanoseconds(stamp.sec, stamp.nanosec) for _, stamp in stamped]
    chosen = headers if any(headers) else [time for time, _ in stamped]
    return np.array([time - chosen[0] for time in chosen], dtype=np.float64) / NANOSECONDS


_TABLES: dict[str, Callable[[Messages, Request], list[ArrayTable]]] = {
    _JOINTS: _joint_states,
    _TRAJECTORY: _trajectories,
    _POSE: _poses,
    **dict.fromkeys(_TRANSFORMS, _transforms),
}
_MOTIONS = (_JOINTS, _TRAJECTORY, _POSE)
