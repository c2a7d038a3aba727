"""Motions as ROS 2 bags, by rosbags (extra `ros`) and without ROS.

A path that ends in .mcap or .db3 becomes one file, which `ros2 bag play` plays as it is; any other
becomes a bag's folder. The bag's time 0 is the motion's start. Each event becomes a String message
on `/events`.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import optional
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io import joint_trajectory, stamps
from leadthrough.io.atomic import StrPath, making_folder, replacing
from leadthrough.io.joint_columns import checked_joint_names
from leadthrough.io.rosbag import EVENTS_TOPIC, humble_types
from leadthrough.io.stamps import NANOSECONDS
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory

_NONE = np.zeros(0)


def write(motion: Motion, path: StrPath) -> None:
    """Writes joints by `write_joint_trajectory`, poses by `write_poses`."""
    if isinstance(motion, JointTrajectory):
        write_joint_trajectory(motion, path)
    elif isinstance(motion, PoseTrajectory):
        write_poses(motion, path)
    else:
        raise InvalidInput(
            "motion: expected joints or poses, which ROS bags can hold, "
            f"got {type(motion).__name__}"
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
    """Writes a PoseStamped message for each sample."""
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
    """A bag that is being written, and its message types. Any: rosbags is optional."""

    writer: Any
    types: Any

    def make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def header(self, time: int, frame: str = "") -> Any:
        stamp = self.make("builtin_interfaces/msg/Time", **stamps.stamp(time))
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
    rosbag2 = optional.load("rosbags.rosbag2", extra="ros")
    types = humble_types()
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    suffix = Path(path).suffix.lower()
    if suffix == ".bag":
        raise InvalidInput(
            "path: expected .mcap, .db3 or the name of a folder, got .bag, which is ROS 1"
        )
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
    due = [round(time * NANOSECONDS) for time in (times - times[0]).tolist()]
    if due[-1] >= 2**31 * NANOSECONDS:
        raise InvalidInput(
            f"motion: expected a duration below 2**31 s, got {times[-1] - times[0]:.6g} s"
        )
    return due
