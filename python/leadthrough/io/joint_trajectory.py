"""Writes joint trajectories as text tables and as ROS 2 messages for ros2_control."""

from __future__ import annotations

import csv
import json
from typing import Any

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.motion import JointTrajectory

# rad/s, m/s: slower than this is standing; the controller wants a velocity of exactly zero.
REST_VELOCITY = 1e-3

_NANOSECONDS = 1_000_000_000


def write_csv(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes one row a sample, to the last digit.

    The columns are `time` in s, then a joint's name for its position, and, where the trajectory
    has them, `<name>_velocity` and `<name>_acceleration`; events have none.
    Raises InvalidInput for joints without different, printable names and for a path that cannot be
    written.
    """
    names = _joint_names(trajectory)
    header, parts = ["time", *names], [trajectory.times[:, None], trajectory.positions]
    for quantity in ("velocity", "acceleration"):
        values = trajectory.velocities if quantity == "velocity" else trajectory.accelerations
        if values is not None:
            header += [f"{name}_{quantity}" for name in names]
            parts.append(values)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(np.hstack(parts).tolist())


def write_json(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes the trajectory in the layout of ROS 2's trajectory_msgs/JointTrajectory.

    Such as ros2_control's joint trajectory controller takes it: the arm stands at the first
    configuration and goes on. As the controller wants every point after time 0, the first sample
    is due one sampling step after the start, and all others as much later. First and last
    velocities, below 1e-3 rad/s, are written as zero.
    Where there are events, they stand under the key "events", which is no part of the ROS message:
    each has a `name` and, like the points, a `time_from_start`.
    Raises InvalidInput for joints without different, printable names, fewer than two samples, no
    velocities (`leadthrough.timing.differentiate` adds them), a motion that does not start and
    end at rest, samples less than a nanosecond apart and a path that cannot be written.
    """
    message = {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(_joint_names(trajectory)),
        "points": _points(trajectory),
    }
    if trajectory.events:
        message["events"] = _events(trajectory)
    text = json.dumps(message, allow_nan=False)
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def _joint_names(trajectory: JointTrajectory) -> tuple[str, ...]:
    if not isinstance(trajectory, JointTrajectory):
        raise InvalidInput(
            f"trajectory: expected a JointTrajectory, got {type(trajectory).__name__}"
        )
    names = trajectory.joint_names
    if not names:
        raise InvalidInput("trajectory: expected joint_names, got none; the robot needs them")
    if len(set(names)) != len(names) or not all(name and name.isprintable() for name in names):
        raise InvalidInput(
            f"trajectory: expected different, printable joint_names, got {list(names)}"
        )
    return names


def _points(trajectory: JointTrajectory) -> list[dict[str, Any]]:
    times = _nanoseconds(trajectory.times)
    velocities = _resting_at_both_ends(trajectory.velocities)
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


def _nanoseconds(times: Float64Array) -> list[int]:
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


def _resting_at_both_ends(velocities: Float64Array | None) -> Float64Array:
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
