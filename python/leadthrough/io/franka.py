"""Joint trajectories for the 1 kHz loop of a Franka arm, as a table of commanded joints.

The columns are named as in libfranka's logs: `time` in s from 0 on, `q_d[0]` to `q_d[6]` in rad and
`dq_d[0]` to `dq_d[6]` in rad/s. There is a row for each cycle of the controller, and a comment for
each event.
"""

from __future__ import annotations

import numpy as np

from leadthrough import events
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath
from leadthrough.io.csv import write_rows
from leadthrough.io.joint_columns import checked_joint_names
from leadthrough.io.rate import at_rate
from leadthrough.motion import JointTrajectory

RATE = 1000.0  # Hz
JOINTS = 7


def write(trajectory: JointTrajectory, path: StrPath) -> None:
    """Writes a row for each millisecond, to the last digit."""
    names = checked_joint_names(trajectory)
    order = sorted(range(len(names)), key=lambda i: names[i][-1])
    if [names[i][-1] for i in order] != list("1234567"):
        raise InvalidInput(
            f"trajectory: expected {JOINTS} joints whose names end in 1 to {JOINTS}, "
            f"got {', '.join(names)}"
        )
    times, positions, velocities = at_rate(trajectory, RATE)
    header = [f"{part}[{i}]" for part in ("q_d", "dq_d") for i in range(JOINTS)]
    rows = np.column_stack([times, positions[:, order], velocities[:, order]])
    own = trajectory.times - trajectory.times[0]
    due_events = events.moved(trajectory.events, trajectory.times, own)
    write_rows(path, ["time", *header], rows, due_events)
