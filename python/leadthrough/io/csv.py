"""Text tables: one sample per row, cells split at commas, semicolons or tabs, named by a header.

The header is the first row that is no comment; where that row is numbers, it is the last comment
before it. Comments begin with `#` and are skipped, except `# event,<time in s>,"<name>"`; so are
empty rows and a byte order mark. `text_table` reads them.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Events
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.io.joint_columns import checked_joint_names, joint_columns, quantities
from leadthrough.io.shown_columns import shown_columns
from leadthrough.io.text_table import EVENT
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory


def write(motion: Motion, path: StrPath) -> None:
    """Writes one row per sample, to the last digit, under names that reading recognises."""
    columns = _columns(motion)
    rows = np.column_stack([motion.times, *columns.values()])
    write_rows(path, ["time", *columns], rows, motion.events)


def write_rows(
    path: StrPath, header: Iterable[str], rows: Float64Array, events: Events = ()
) -> None:
    """Writes a table to the last digit, and a comment for each event."""
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows.tolist())
        file.writelines(f"{EVENT}{each.time!r},{json.dumps(each.name)}\n" for each in events)


def _columns(motion: Motion) -> dict[str, Float64Array]:
    if isinstance(motion, JointTrajectory):
        return joint_columns(checked_joint_names(motion), quantities(motion))
    width = motion.positions.shape[1]
    if width not in (2, 3):
        raise InvalidInput(
            f"motion: expected points of two or three coordinates, got {width}; .npz takes any"
        )
    columns = dict(zip("xyz", motion.positions.T, strict=False))
    if isinstance(motion, PoseTrajectory):
        columns |= dict(zip(("qw", "qx", "qy", "qz"), motion.orientations.T, strict=True))
    return columns | shown_columns(motion)
