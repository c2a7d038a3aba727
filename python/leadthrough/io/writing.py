"""Writes motions to files of any format."""

from __future__ import annotations

import os

from leadthrough.errors import InvalidInput
from leadthrough.io import formats
from leadthrough.io.atomic import StrPath
from leadthrough.motion import Motion, checked_motion


def write_motion(motion: Motion, path: StrPath, *, format: str | None = None) -> None:
    """Writes a motion to a file, which appears whole or not at all.

    The joints that a motion of the tip carries along (`motion.joints`) are kept by "csv" and "npz".

    The modules of the formats say what each keeps and needs, and have functions with options:
    `io.joint_trajectory`, `io.rosbag_writer`, `io.urscript` and `io.franka`.

    Args:
        motion: points, poses or joints, as far as the format has them.
        path: file to write.
        format: "csv", "npz", "json", "yaml", "rosbag", "urscript" or "franka"; by default the one
            whose suffix the path has: .csv, .npz, .json, .yaml, .mcap, .db3 or .script.

    Raises:
        InvalidInput: if the format is unknown or cannot hold this motion, or the path cannot be
            written.
        MissingDependency: if the format needs an extra.
    """
    checked_motion(motion, "motion")
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    write = formats.to_write(path, format).write
    assert write is not None
    write(motion, path)
