"""ROS bags, by rosbags (extra `ros`) and without ROS: ROS 1, and ROS 2 with SQLite or MCAP.

JointState, JointTrajectory, PoseStamped and, for named frames, transforms are read. Times are those
of the messages' headers, or of the bag where these are zero, counted from the first message. Text
messages on `/events` become events.

Motions are written as ROS 2 bags: .mcap and .db3 name one file, which `ros2 bag play` plays as it
is; any other path becomes a bag's folder. The bag's time 0 is the motion's start.
"""

from __future__ import annotations

import shutil
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io import files, joint_trajectory
from leadthrough.io.files import ReadLimits, StrPath, checked_path, refusing_damage, replacing
from leadthrough.io.headers import JOINT_SUFFIXES, Columns
from leadthrough.io.joint_trajectory import (
    NANOSECONDS,
    checked_joint_names,
    joint_columns,
    stamp_nanoseconds,
    to_stamp,
)
from leadthrough.io.table import ArrayTable, Request
from leadthrough.motion import Event, Events, JointTrajectory, Motion, PoseTrajectory

EVENTS_TOPIC = "/events"  # one String message per event

# The bag's time in ns and the message. Any: classes that rosbags makes at run time.
Messages = list[tuple[int, Any]]

_JOINTS = "sensor_msgs/msg/JointState"
_TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
_POSE = "geometry_msgs/msg/PoseStamped"
_TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
# Source: the MCAP specification: magic, then records of a kind, a length and a content; that of a
# chunk begins with two times and its size when inflated.
_MCAP_MAGIC = 8
_MCAP_RECORD = struct.Struct("<BQ")
_MCAP_CHUNK_KIND = 6
_MCAP_CHUNK = struct.Struct("<16xQ")
_ITEMS_PER_MESSAGE = 16  # objects that a message becomes
_MOTIONS = (_JOINTS, _TRAJECTORY, _POSE)
_EMPTY = np.zeros(0)


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
    highlevel = check.package("rosbags.highlevel", extra="ros")
    store = humble_types()
    with refusing_damage("ROS bag"):
        for file in path.glob("*.mcap") if path.is_dir() else [path]:
            if file.suffix.lower() == ".mcap":
                _check_chunks(file)
        with highlevel.AnyReader([path], default_typestore=store) as bag:
            yield bag


def humble_types() -> Any:  # Any: rosbags is optional
    """The message types of ROS 2 Humble; older SQLite bags don't carry their own."""
    typesys = check.package("rosbags.typesys", extra="ros")
    return typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)


def _check_chunks(path: Path) -> None:
    """Refuses an MCAP file with a chunk that claims to inflate beyond the limits."""
    size = path.stat().st_size
    at = _MCAP_MAGIC
    with path.open("rb") as file:
        while at + _MCAP_RECORD.size <= size:
            file.seek(at)
            kind, length = _MCAP_RECORD.unpack(file.read(_MCAP_RECORD.size))
            head = file.read(_MCAP_CHUNK.size) if kind == _MCAP_CHUNK_KIND else b""
            if len(head) == _MCAP_CHUNK.size:
                ReadLimits().bytes(_MCAP_CHUNK.unpack(head)[0], "a chunk")
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
    limits = ReadLimits()
    for connection, time, data in bag.messages(connections=connections):
        limits.items(_ITEMS_PER_MESSAGE, topic)
        limits.bytes(len(data), topic)
        found.append((time, bag.deserialize(data, connection.msgtype)))
    return found


def _events(bag: Any, start: int, table: ArrayTable) -> Events:
    """The events on the table's clock; its first sample came at `start`, ns on the bag's clock."""
    info = bag.topics.get(EVENTS_TOPIC)
    if info is None or info.msgtype != "std_msgs/msg/String":
        return ()
    first = float(table.numbers(table.roles["time"][0])[0])
    return tuple(
        Event(first + (time - start) / NANOSECONDS, message.data)
        for time, message in _messages(bag, EVENTS_TOPIC)
    )


def _joint_states(messages: Messages, request: Request) -> list[ArrayTable]:
    stamps = _times([(time, message.header.stamp) for time, message in messages])
    states = [message for _, message in messages]
    return [joint_state_table(stamps, states, request.columns.get("joints"))]


def _trajectories(messages: Messages, _: Request) -> list[ArrayTable]:
    return [
        joint_trajectory.table(
            {"joint_names": message.joint_names, "points": [*map(_point, message.points)]}
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
    headers = [stamp_nanoseconds(stamp.sec, stamp.nanosec) for _, stamp in stamped]
    chosen = headers if any(headers) else [time for time, _ in stamped]
    return np.array([time - chosen[0] for time in chosen], dtype=np.float64) / NANOSECONDS


_TABLES: dict[str, Callable[[Messages, Request], list[ArrayTable]]] = {
    _JOINTS: _joint_states,
    _TRAJECTORY: _trajectories,
    _POSE: _poses,
    **dict.fromkeys(_TRANSFORMS, _transforms),
}


class JointState(Protocol):
    """A sensor_msgs/JointState."""

    name: Sequence[str]
    position: Sequence[float]
    velocity: Sequence[float]


def joint_state_table(
    times: Float64Array, states: Sequence[JointState], wanted: Columns | None
) -> ArrayTable:
    """The positions of joints, and their velocities where every message has them."""
    groups = {frozenset(state.name): tuple(state.name) for state in states if state.name}
    if wanted is None and len(groups) != 1:
        listed = " | ".join(", ".join(group) for group in groups.values()) or "none"
        raise InvalidInput(
            f"columns: the messages have different joints, {listed}; "
            "name the ones to read in columns['joints']"
        )
    joints = wanted or next(iter(groups.values()))
    _check_known(joints, groups)
    together = [i for i, state in enumerate(states) if set(joints) <= set(state.name)]
    if not together:
        return _merged(times, states, joints)
    whole = [states[i] for i in together]
    values = {"positions": _matrix(whole, joints, "position")}
    if all(len(state.velocity) == len(state.name) for state in whole):
        velocities = _matrix(whole, joints, "velocity")
        if np.isfinite(velocities).all():
            values["velocities"] = velocities
    return _joint_table(times[together], joints, joint_columns(joints, values))


def _joint_table(
    times: Float64Array, joints: Columns, columns: Mapping[str, Float64Array]
) -> ArrayTable:
    roles = {"time": ("time",), "joints": joints}
    return ArrayTable({"time": times, **columns}, roles=roles, angles="radians")


def _check_known(joints: Columns, groups: dict[frozenset[str], Columns]) -> None:
    known = {name: None for group in groups.values() for name in group}
    missing = [joint for joint in joints if joint not in known]
    if missing:
        listed = ", ".join(known)
        raise InvalidInput(f"columns['joints']: no joint {missing[0]!r}; there are {listed}")


def _matrix(states: Sequence[JointState], joints: Columns, field: str) -> Float64Array:
    rows = []
    for state in states:
        values = getattr(state, field)
        if len(values) != len(state.name):
            raise InvalidInput(
                f"{field}: expected {len(state.name)} numbers, one for each of "
                f"{', '.join(state.name)}, got {len(values)}"
            )
        rows.append([values[state.name.index(joint)] for joint in joints])
    return np.array(rows, dtype=np.float64)


def _merged(times: Float64Array, states: Sequence[JointState], joints: Columns) -> ArrayTable:
    series = []
    for joint in joints:
        rows = [i for i, state in enumerate(states) if joint in state.name]
        at, values = times[rows], _matrix([states[i] for i in rows], (joint,), "position")[:, 0]
        order = np.argsort(at, kind="stable")
        series.append((at[order], values[order]))
    first, last = max(at[0] for at, _ in series), min(at[-1] for at, _ in series)
    clock = series[0][0]
    clock = clock[(clock >= first) & (clock <= last)]
    if len(clock) == 0:
        raise InvalidInput(
            f"columns['joints']: {', '.join(joints)} were not recorded at the same time; "
            "read them one by one"
        )
    columns = {joint: np.interp(clock, *own) for joint, own in zip(joints, series, strict=True)}
    return _joint_table(clock, joints, columns)


def write(motion: Motion, path: StrPath) -> None:
    """Writes joints by `write_joint_trajectory`, poses by `write_poses`."""
    if isinstance(motion, JointTrajectory):
        write_joint_trajectory(motion, path)
    elif isinstance(motion, PoseTrajectory):
        write_poses(motion, path)
    else:
        raise check.refused(
            "motion", "joints or poses, which ROS bags can hold", type(motion).__name__
        )


def write_joint_trajectory(
    trajectory: JointTrajectory,
    path: StrPath,
    *,
    topic: str = "/joint_trajectory_controller/joint_trajectory",
) -> None:
    """Writes a single JointTrajectory message, which moves the arm when the bag is played."""
    content = joint_trajectory.message(trajectory)
    with _bag(path) as bag:
        points = [
            bag.make(
                "trajectory_msgs/msg/JointTrajectoryPoint",
                positions=np.array(point["positions"]),
                velocities=np.array(point["velocities"]),
                accelerations=np.array(point["accelerations"]),
                effort=_EMPTY,
                time_from_start=bag.make(
                    "builtin_interfaces/msg/Duration", **point["time_from_start"]
                ),
            )
            for point in content["points"]
        ]
        message = bag.make(
            "trajectory_msgs/msg/JointTrajectory",
            header=bag.header(0),
            joint_names=content["joint_names"],
            points=points,
        )
        bag.write(topic, [(0, message)])
        bag.write_events(trajectory)


def write_joint_states(
    trajectory: JointTrajectory, path: StrPath, *, topic: str = "/joint_states"
) -> None:
    """Writes a JointState message for each sample, with velocities where there are some."""
    names = list(checked_joint_names(trajectory))
    speeds = trajectory.velocities
    with _bag(path) as bag:
        messages = [
            (
                time,
                bag.make(
                    "sensor_msgs/msg/JointState",
                    header=bag.header(time),
                    name=names,
                    position=trajectory.positions[i],
                    velocity=_EMPTY if speeds is None else speeds[i],
                    effort=_EMPTY,
                ),
            )
            for i, time in enumerate(_nanoseconds(trajectory.times))
        ]
        bag.write(topic, messages)
        bag.write_events(trajectory)


def write_poses(
    motion: PoseTrajectory, path: StrPath, *, topic: str = "/pose", frame: str = "base_link"
) -> None:
    """Writes a PoseStamped message for each sample."""
    check.instance(motion, "motion", PoseTrajectory)
    with _bag(path) as bag:
        messages = []
        for i, time in enumerate(_nanoseconds(motion.times)):
            w, x, y, z = motion.orientations[i].tolist()
            point = dict(zip("xyz", motion.positions[i].tolist(), strict=True))
            pose = bag.make(
                "geometry_msgs/msg/Pose",
                position=bag.make("geometry_msgs/msg/Point", **point),
                orientation=bag.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w),
            )
            stamped = bag.make(
                "geometry_msgs/msg/PoseStamped", header=bag.header(time, frame), pose=pose
            )
            messages.append((time, stamped))
        bag.write(topic, messages)
        bag.write_events(motion)


@dataclass(frozen=True, eq=False)
class _Bag:
    """A bag that is being written, and its message types. Any: rosbags is optional."""

    writer: Any
    types: Any

    def make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def header(self, time: int, frame: str = "") -> Any:
        stamp = self.make("builtin_interfaces/msg/Time", **to_stamp(time))
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def write_events(self, motion: Motion) -> None:
        """Writes each event at its time from the motion's start."""
        messages = [
            (
                round((event.time - float(motion.times[0])) * NANOSECONDS),
                self.make("std_msgs/msg/String", data=event.name),
            )
            for event in motion.events
        ]
        if messages:
            self.write(EVENTS_TOPIC, messages)

    def write(self, topic: str, messages: list[tuple[int, Any]]) -> None:
        kind = messages[0][1].__msgtype__
        connection = self.writer.add_connection(topic, kind, typestore=self.types)
        for time, message in messages:
            self.writer.write(connection, time, self.types.serialize_cdr(message, kind))


@contextmanager
def _bag(path: StrPath) -> Iterator[_Bag]:
    rosbag2 = check.package("rosbags.rosbag2", extra="ros")
    types = humble_types()
    suffix = checked_path(path).suffix.lower()
    if suffix == ".bag":
        raise check.refused("path", ".mcap, .db3 or the name of a folder", ".bag, which is ROS 1")
    storage = rosbag2.StoragePlugin
    plugin = storage.MCAP if suffix == ".mcap" else storage.SQLITE3
    with (
        _folder_or_file(path, suffix) as folder,
        rosbag2.Writer(folder, version=8, storage_plugin=plugin) as writer,
    ):
        yield _Bag(writer, types)


@contextmanager
def _folder_or_file(path: StrPath, suffix: str) -> Iterator[Path]:
    """A folder to write the bag to; it, or the one file in it, becomes what the path names."""
    if suffix not in (".mcap", ".db3"):
        with files.making_folder(path) as folder:
            yield folder
        return
    with replacing(path) as temporary:
        folder = temporary.with_suffix("")
        try:
            yield folder
            (storage,) = folder.glob(f"*{suffix}")
            storage.replace(temporary)
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def _nanoseconds(times: Float64Array) -> list[int]:
    due = [round(time * NANOSECONDS) for time in (times - times[0]).tolist()]
    if due[-1] >= 2**31 * NANOSECONDS:
        raise check.refused("motion", "a duration below 2**31 s", f"{times[-1] - times[0]:.6g} s")
    return due
