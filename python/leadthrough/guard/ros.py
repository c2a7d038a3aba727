"""A guard between ROS 2 nodes: trajectory_msgs/JointTrajectory in and out, as rosbags has it."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.guard.admission import Admission
from leadthrough.guard.guard import Guard
from leadthrough.io.joint_trajectory import NANOSECONDS, stamp_nanoseconds, to_stamp
from leadthrough.io.rosbag import humble_types
from leadthrough.motion import JointTrajectory

_MESSAGE = "trajectory_msgs/msg/JointTrajectory"


# Any: messages are of rosbags' types, which are made when it loads, or of rclpy's with the same
# attributes.
def admit_message(guard: Guard, message: Any, state: Any = None) -> tuple[Any, Admission]:
    """The admitted motion of a message, as a message of rosbags' types, and the guard's answer.

    The message that comes back goes on to rest, so that a controller that gets nothing more stops.
    Its header and its joints are those of the message that came; joints that are not the arm's are
    left out.

    Raises:
        InvalidInput: if the message has no points or lacks a joint of the arm, and as `admit`.
        MissingDependency: if rosbags is not installed.
    """
    answer = guard.admit(trajectory_of(message), state)
    return message_of(answer.to_rest, header=message.header), answer


def trajectory_of(message: Any) -> JointTrajectory:
    """The motion of a message, timed by `time_from_start`.

    Raises:
        InvalidInput: if it has no points, or they do not fit its joints.
    """
    points = list(message.points)
    if not points:
        raise InvalidInput("message: expected at least one point, got none")
    due = [point.time_from_start for point in points]
    times = [stamp_nanoseconds(each.sec, each.nanosec) / NANOSECONDS for each in due]
    return JointTrajectory(
        times,
        np.array([point.positions for point in points], dtype=np.float64),
        _column([point.velocities for point in points]),
        _column([point.accelerations for point in points]),
        tuple(message.joint_names),
    )


def message_of(trajectory: JointTrajectory, *, header: Any = None) -> Any:
    """A motion as a message of rosbags' types, timed by `time_from_start`.

    Args:
        trajectory: with the names of its joints.
        header: of the message; by default an empty one.

    Raises:
        InvalidInput: if the joints have no names.
        MissingDependency: if rosbags is not installed.
    """
    check.instance(trajectory, "trajectory", JointTrajectory)
    if not trajectory.joint_names:
        raise InvalidInput("trajectory: expected the names of its joints, got none")
    types = humble_types().types
    if header is None:
        stamp = types["builtin_interfaces/msg/Time"](**to_stamp(0))
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
    none = np.empty(0)
    rows = [
        np.empty((len(trajectory), 0)) if given is None else given
        for given in (trajectory.velocities, trajectory.accelerations)
    ]
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            positions=q,
            velocities=qd,
            accelerations=qdd,
            effort=none,
            time_from_start=types["builtin_interfaces/msg/Duration"](
                **to_stamp(round(time * NANOSECONDS))
            ),
        )
        for time, q, qd, qdd in zip(
            trajectory.times.tolist(), trajectory.positions, *rows, strict=True
        )
    ]
    return types[_MESSAGE](header=header, joint_names=list(trajectory.joint_names), points=points)


def _column(rows: list[Any]) -> Float64Array | None:
    """Numbers of all points, or None where some have none."""
    return np.array(rows, dtype=np.float64) if all(len(row) for row in rows) else None
