"""Motions as ROS 2 bags, by rosbags (extra `ros`) and without ROS.

A path that ends in .mcap or .db3 becomes one file, which `ros2 bag play` takes as it is; any other
becomes a bag's folder. The bag begins at time 0, where the motion begins. Events are a String each,
on `/events`.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.io import joint_trajectory
from leadthrough.io.atomic import StrPath, making_folder, replacing
from leadthrough.io.joint_names import checked_joint_names
from leadthrough.io.rosbag import EVENTS_TOPIC
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory

_NANOSECONDS = 1_000_000_000
_NONE = np.zeros(0)


def write(motion: Motion, path: StrPath) -> None:
    """Writes joints by `write_joint_trajectory`, poses by `write_poses`. Raises as they do."""
    if isinstance(motion, JointTrajectory):
        write_joint_trajectory(motion, path)
    elif isinstance(motion, PoseTrajectory):
        write_poses(motion, path)
    else:
        raise InvalidInput(f"motion: expected joints or poses, got {type(motion).__name__}")


def write_joint_trajectory(
    trajectory: JointTrajectory,
    path: StrPath,
    *,
    topic: str = "/joint_trajectory_controller/joint_trajectory",
) -> None:
    """Writes one JointTrajectory, which moves the arm when the bag is played.

    Raises InvalidInput as `joint_trajectory.message` does, and for a path that cannot be written;
    MissingDependency.
    """
    content = joint_trajectory.message(trajectory)
    with _bag(path) as bag:
        points = [
            bag.make(
                "trajectory_msgs/msg/JointTrajectoryPoint",
                positions=np.array(point["positions"]),
                velocities=np.array(point["velocities"]),
                accelerations=np.array(point["accelerations"]),
                effort=_NONE,
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
    """Writes a JointState for each sample, with velocities where there are some.

    Raises InvalidInput for joints without different, printable names and a path that cannot be
    written; MissingDependency.
    """
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
                    velocity=_NONE if speeds is None else speeds[i],
                    effort=_NONE,
                ),
            )
            for i, time in enumerate(_nanoseconds(trajectory.times))
        ]
        bag.write(topic, messages)
        bag.write_events(trajectory)


def write_poses(
    motion: PoseTrajectory, path: StrPath, *, topic: str = "/pose", frame: str = "base_link"
) -> None:
    """Writes a PoseStamped for each sample, in a frame.

    Raises InvalidInput for another motion and a path that cannot be written; MissingDependency.
    """
    if not isinstance(motion, PoseTrajectory):
        raise InvalidInput(f"motion: expected a PoseTrajectory, got {type(motion).__name__}")
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
    """A bag that is being written, and the types of its messages."""

    writer: Any
    types: Any

    def make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def header(self, time: int, frame: str = "") -> Any:
        sec, nanosec = divmod(time, _NANOSECONDS)
        stamp = self.make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def write_events(self, motion: Motion) -> None:
        """Writes what happens, each at its time from the motion's start."""
        messages = [
            (
                round((event.time - float(motion.times[0])) * _NANOSECONDS),
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
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    except ImportError:
        raise MissingDependency("rosbags", extra="ros") from None
    suffix = Path(path).suffix.lower()
    if suffix == ".bag":
        raise InvalidInput("path: expected .mcap, .db3 or a folder's name, got .bag, as of ROS 1")
    plugin = StoragePlugin.MCAP if suffix == ".mcap" else StoragePlugin.SQLITE3
    types = get_typestore(Stores.ROS2_HUMBLE)
    with (
        _folder_or_file(path, suffix) as folder,
        Writer(folder, version=8, storage_plugin=plugin) as writer,
    ):
        yield _Bag(writer, types)


@contextmanager
def _folder_or_file(path: StrPath, suffix: str) -> Iterator[Path]:
    """A folder to write the bag to; what becomes of it is what the path asks for."""
    if suffix not in (".mcap", ".db3"):
        with making_folder(path) as folder:
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
    stamps = [round(time * _NANOSECONDS) for time in (times - times[0]).tolist()]
    if stamps[-1] >= 2**31 * _NANOSECONDS:
        raise InvalidInput("motion: expected a duration below 2**31 s")
    return stamps
