"""Reading and writing, one format a file; `leadthrough.io.formats` lists them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from leadthrough.errors import InvalidInput
from leadthrough.io import formats, franka, joint_trajectory, lasa, rosbag_writer, urscript
from leadthrough.io.atomic import StrPath
from leadthrough.io.recording import Recording, check_complete, recording
from leadthrough.io.request import Request, checked
from leadthrough.io.table import Table
from leadthrough.motion import Demonstration, Motion

__all__ = [
    "Recording",
    "formats",
    "franka",
    "joint_trajectory",
    "lasa",
    "read_demonstrations",
    "read_recordings",
    "rosbag_writer",
    "urscript",
    "write_motion",
]


def read_demonstrations(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: str | None = None,
    quaternions: str | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
) -> list[Demonstration]:
    """The demonstrations in one file or several, in their order; nothing may be wrong with them.

    paths: text tables (.csv, .tsv, .txt), .npz, .mat, ROS 2 JointTrajectory (.json, .yaml), ROS
    bags (.bag, .mcap, .db3 or a folder; extra `ros`), robomimic (.hdf5; extra `hdf5`), LeRobot
    (.parquet or a folder; extra `lerobot`). Demonstrations are named after the file, with [i]
    where it has several and no names of its own for them.
    columns: which columns, arrays or fields to read, any of {"time": name, "positions": [names],
    "orientations": [names], "joints": [names]}. Joints make a JointTrajectory, positions and
    orientations a PoseTrajectory, positions alone a Trajectory. Without a motion named here it is
    found by the names in the file (`leadthrough.io.headers` lists them), as the time is (s).
    rate: Hz, > 0, for files without time, whose first sample is then at 0 s.
    angles: "radians" or "degrees", of joints whose names don't say; left out they are radians, and
    refused where they stay beyond two turns.
    quaternions: "wxyz" or "xyzw", the order of four numbers that no name tells apart.
    topic: of a bag, where several fit. frames: (frame, child) of a bag's transforms.
    Raises InvalidInput, which names the file and where it is at fault, and MissingDependency.
    """
    request = checked(
        columns=columns,
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=frames,
    )
    return [
        Demonstration(_strictly(path, found, table, request), name=found.name)
        for path in _paths(paths)
        for table, found in _recordings(path, request)
    ]


def read_recordings(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: str | None = None,
    quaternions: str | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
) -> list[Recording]:
    """What `read_demonstrations` reads, with missing values and faulty times as they are.

    `leadthrough.preprocess.clean` makes demonstrations of them.
    Raises InvalidInput, MissingDependency.
    """
    request = checked(
        columns=columns,
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=frames,
    )
    return [found for path in _paths(paths) for _, found in _recordings(path, request)]


def write_motion(motion: Motion, path: StrPath, *, format: str | None = None) -> None:
    """Writes a motion in the format that the path's suffix names, or the one that is given.

    format: "csv", "npz", "json", "yaml", "rosbag", "urscript" or "franka"; by default that of .csv,
    .npz, .json, .yaml, .mcap, .db3 and .script. The file appears whole or not at all. The
    functions of each format say what it keeps and what it asks for, and have options:
    `io.joint_trajectory`, `io.rosbag_writer`, `io.urscript`, `io.franka`.
    Raises InvalidInput, MissingDependency.
    """
    if not isinstance(motion, Motion):
        raise InvalidInput(f"motion: expected a motion, got {type(motion).__name__}")
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    write = formats.to_write(path, format).write
    assert write is not None
    write(motion, path)


def _paths(paths: Any) -> list[Path]:
    several = [paths] if isinstance(paths, str | os.PathLike) else paths
    if not isinstance(several, Sequence) or not all(
        isinstance(path, str | os.PathLike) for path in several
    ):
        raise InvalidInput(f"paths: expected a path or a sequence of paths, got {paths!r}")
    if not several:
        raise InvalidInput("paths: expected at least one path, got none")
    return [Path(path) for path in several]


def _recordings(path: Path, request: Request) -> Iterator[tuple[Table, Recording]]:
    try:
        read = formats.of_file(path).read
        assert read is not None
        tables = read(path, request)
        for i, table in enumerate(tables):
            own = path.stem if len(tables) == 1 else f"{path.stem}[{i}]"
            yield table, recording(table, request, name=table.label or own)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def _strictly(path: Path, found: Recording, table: Table, request: Request) -> Motion:
    try:
        return found.motion()
    except InvalidInput as error:
        reason = error
    try:
        check_complete(table, request)  # knows the place in the file
    except InvalidInput as error:
        reason = error
    raise InvalidInput(f"{path}: {reason}")
