"""Joint trajectories for the 1 kHz loop of a Franka arm, as a table of commanded joints.

The columns are named as in libfranka's logs: `time` in s from 0 on, `q_d[0]` to `q_d[6]` in rad and
`dq_d[0]` to `dq_d[6]` in rad/s, a row for each cycle of the controller; a comment for each event.
"""

from __future__ import annotations

import csv

import numpy as np

from leadthrough import events
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.io.csv import event_rows
from leadthrough.io.joint_names import checked_joint_names
from leadthrough.io.sampling import at_rate
from leadthrough.motion import JointTrajectory

RATE = 1000.0  # Hz
JOINTS = 7


def write(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes a row for each millisecond, to the last digit.

    Joints are put in order by the numbers, 1 to 7, that their names end in.
    Raises InvalidInput for other joints, motions without velocities or that do not start and end
    at rest, and a path that cannot be written.
    """
    names = checked_joint_names(trajectory)
    order = sorted(range(len(names)), key=lambda i: names[i][-1])
    if [names[i][-1] for i in order] != list("1234567"):
        raise InvalidInput(
            f"trajectory: expected seven joints numbered 1 to {JOINTS}, got {', '.join(names)}"
        )
    times, positions, velocities = at_rate(trajectory, RATE)
    header = [f"{part}[{i}]" for part in ("q_d", "dq_d") for i in range(JOINTS)]
    own = trajectory.times - trajectory.times[0]
    rows = np.column_stack([times, positions[:, order], velocities[:, order]])
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time", *header])
        writer.writerows(rows.tolist())
        file.writelines(event_rows(events.moved(trajectory.events, trajectory.times, own)))
