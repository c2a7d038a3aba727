"""File formats, identified by suffix or, for folders, by contents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from leadthrough import check
from leadthrough.check import InvalidInput
from leadthrough.io import csv, joint_trajectory, lerobot, mat, npz, robomimic, rosbag
from leadthrough.io.files import StrPath, checked_path
from leadthrough.io.reader_process import require, tables
from leadthrough.io.robot_programs import write_franka, write_urscript
from leadthrough.io.table import ArrayTable, Request, Table
from leadthrough.motion import Motion, checked_motion

Read = Callable[[Path, Request], Sequence[Table]]
Write = Callable[[Any, StrPath], None]  # Any: each checks whether it can write the motion


@dataclass(frozen=True)
class Format:
    """One format, to read, to write or both."""

    name: str  # as `write_motion` takes it
    title: str  # for messages and lists
    suffixes: tuple[str, ...]  # of its files, with their dot, in lower case
    read: Read | None = None  # returns the tables in a file
    write: Write | None = None  # writes a motion to a file
    marker: str | None = None  # file that marks a folder of this format
    extra: str | None = None  # of leadthrough, which the format needs

    def tables(self, path: Path, request: Request) -> Sequence[Table]:
        """The tables in a file or folder."""
        assert self.read is not None
        return self.read(path, request)


def _one(read: Callable[[Path], Table]) -> Read:
    return lambda path, _: [read(path)]


def _in_reader_process(
    read: Callable[..., Sequence[ArrayTable]], module: str, extra: str, *, asked: bool = False
) -> Read:
    """A reader in the reader process; `asked` if it also takes the request."""

    def found(path: Path, request: Request) -> Sequence[Table]:
        require(module, extra=extra)
        return tables(read, path, request if asked else None)

    return found


FORMATS = (
    Format("csv", "text table", (".csv", ".tsv", ".txt"), _one(csv.read_table), csv.write),
    Format("npz", "NumPy archive", (".npz",), _one(npz.table), npz.write),
    Format("npy", "NumPy array", (".npy",), lambda path, asked: [npz.table_of_rows(path, asked)]),
    Format("mat", "MATLAB 5 to 7.2", (".mat",), lambda path, _: mat.tables(path)),
    Format(
        "json",
        "ROS 2 JointTrajectory",
        (".json",),
        _one(joint_trajectory.table_of_json),
        joint_trajectory.write_json,
    ),
    Format(
        "yaml",
        "ROS 2 JointTrajectory",
        (".yaml", ".yml"),
        _one(joint_trajectory.table_of_yaml),
        joint_trajectory.write_yaml,
    ),
    Format(
        "rosbag",
        "ROS bag",
        (".mcap", ".db3", ".bag"),
        _in_reader_process(rosbag.tables, "rosbags.highlevel", "ros", asked=True),
        rosbag.write,
        marker="metadata.yaml",
        extra="ros",
    ),
    Format(
        "robomimic",
        "robomimic HDF5",
        (".hdf5", ".h5"),
        _in_reader_process(robomimic.tables, "h5py", "hdf5"),
        extra="hdf5",
    ),
    Format(
        "lerobot",
        "LeRobot Parquet",
        (".parquet",),
        _in_reader_process(lerobot.tables, "pyarrow.parquet", "lerobot"),
        marker="meta/info.json",
        extra="lerobot",
    ),
    Format("urscript", "URScript program", (".script", ".urscript"), write=write_urscript),
    Format("franka", "Franka, 1 kHz", (), write=write_franka),
)


def of_file(path: Path) -> Format:
    """The format of a file or folder to read."""
    if path.is_dir():
        for found in FORMATS:
            if found.marker is not None and (path / found.marker).is_file():
                return found
        raise InvalidInput("expected a file, a ROS 2 bag or a LeRobot data set, got another folder")
    if not path.is_file():
        raise InvalidInput("no such file")
    readable = [each for each in FORMATS if each.read is not None]
    for each in readable:
        if path.suffix.lower() in each.suffixes:
            return each
    raise InvalidInput(f"expected {_suffixes(readable)}, got {path.suffix!r}")


def to_write(path: StrPath, name: str | None) -> Format:
    """The format to write."""
    writable = [each for each in FORMATS if each.write is not None]
    suffix = Path(path).suffix.lower()
    for each in writable:
        if each.name == name or (name is None and suffix in each.suffixes):
            return each
    if name is None:
        raise check.refused("path", _suffixes(writable), f"{suffix!r}; change it or set format")
    names = ", ".join(repr(each.name) for each in writable)
    raise InvalidInput(f"format: expected one of {names}, got {name!r}")


def _suffixes(formats: Sequence[Format]) -> str:
    *others, last = (suffix for each in formats for suffix in each.suffixes)
    return f"{', '.join(others)} or {last}"


def write_motion(motion: Motion, path: StrPath, *, format: str | None = None) -> None:
    """Writes a motion to a file, completely or not at all.

    The joints that a motion of the tip carries along (`motion.joints`) are kept by "csv" and "npz".

    The modules of the formats say what each keeps and needs, and have functions with options:
    `io.joint_trajectory`, `io.rosbag` and `io.robot_programs`.

    Args:
        motion: points, poses or joints, as far as the format has them.
        format: "csv", "npz", "json", "yaml", "rosbag", "urscript" or "franka"; by default the one
            whose suffix the path has: .csv, .npz, .json, .yaml, .mcap, .db3 or .script.

    Raises:
        InvalidInput: if the format is unknown or cannot hold this motion, or the path cannot be
            written.
        MissingDependency: if the format needs an extra.
    """
    checked_motion(motion, "motion")
    checked_path(path)
    write = to_write(path, format).write
    assert write is not None
    write(motion, path)
