"""Reads recordings and demonstrations from files of any format."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from leadthrough.errors import InvalidInput
from leadthrough.io import formats
from leadthrough.io.atomic import StrPath
from leadthrough.io.columns import check_complete, recording
from leadthrough.io.headers import AngleUnit, QuaternionOrder
from leadthrough.io.recording import Recording
from leadthrough.io.request import Request, checked
from leadthrough.io.table import Table
from leadthrough.motion import Demonstration, Motion
from leadthrough.rest import trim


def read_demonstrations(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: AngleUnit | None = None,
    quaternions: QuaternionOrder | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
    joints: Mapping[str, tuple[float, float]] | None = None,
    rest: float = 0.0,
) -> list[Demonstration]:
    """The demonstrations in one or several files, in their order; files with faults are refused.

    The standing still before and after what was shown is left out, as `preprocess.trim` does; times
    are as in the file. For motions that an arm is to run, whole, there is `read_motion`.

    Formats are text tables (.csv, .tsv, .txt), .npz, .mat, ROS 2 JointTrajectory (.json, .yaml),
    ROS bags (.bag, .mcap, .db3 or a folder; extra `ros`), robomimic (.hdf5; extra `hdf5`) and
    LeRobot (.parquet or a folder; extra `lerobot`). A demonstration is named as in the file, or
    else after it, with [i] where the file has several.

    Joints make a JointTrajectory, positions and orientations a PoseTrajectory, positions alone a
    Trajectory. A motion and a time (s) that `columns` does not name are found by the names in the
    file, which `leadthrough.io.headers` lists.

    Args:
        paths: one file or folder, or several.
        columns: which columns, arrays or fields to read, any of {"time": name, "positions":
            [names], "orientations": [names], "joints": [names]}.
        rate: Hz, > 0, for files without time; their first sample is then at 0 s.
        angles: unit of joints whose names don't state it, by default radians. Joints that stay
            beyond two turns are refused until it is set. "percent" of the joints' ranges, as in
            LeRobot's data sets, go from -100 to 100, of a gripper from 0 to 100.
        quaternions: order of four numbers whose names don't state it.
        topic: topic of a bag, where several have motions.
        frames: frame and child frame of a transform in a bag.
        joints: an arm's joints by name, with their lower and upper limits in rad (m). Columns of
            these names are its joints, whatever else the file has; percent refer to the limits.
        rest: s of standing still to keep before and after, >= 0; `math.inf` keeps all of it.

    Raises:
        InvalidInput: if an argument is wrong, or a file cannot be read or has faults; the message
            says which and where.
        MissingDependency: if the format needs an extra.
    """
    request = checked(
        columns=columns,
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=frames,
        joints=joints,
    )
    return [trim(each, rest=rest) for each in _demonstrations(paths_of(paths), request)]


def read_motion(
    path: StrPath,
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: AngleUnit | None = None,
    quaternions: QuaternionOrder | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
    joints: Mapping[str, tuple[float, float]] | None = None,
) -> Motion:
    """The only motion in a file, whole, as `write_motion` writes it.

    Formats, names and columns are as for `read_demonstrations`.

    Args:
        path: a file or folder.
        columns: which columns, arrays or fields to read, by role.
        rate: Hz, > 0, for files without time.
        angles: unit of joints whose names don't state it.
        quaternions: order of four numbers whose names don't state it.
        topic: topic of a bag, where several have motions.
        frames: frame and child frame of a transform in a bag.
        joints: an arm's joints by name, with their lower and upper limits in rad (m).

    Raises:
        InvalidInput: if the file cannot be read, has faults, or has not exactly one motion.
        MissingDependency: if the format needs an extra.
    """
    request = checked(
        columns=columns,
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=frames,
        joints=joints,
    )
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected the path of one file or folder, got {path!r}")
    found = _demonstrations([Path(path)], request)
    if len(found) != 1:
        raise InvalidInput(
            f"{printable(Path(path))}: expected a file with one motion, got {len(found)}"
        )
    return found[0].motion


def read_recordings(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: AngleUnit | None = None,
    quaternions: QuaternionOrder | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
    joints: Mapping[str, tuple[float, float]] | None = None,
) -> list[Recording]:
    """The recordings in one or several files, with missing numbers and faulty times as they are.

    `leadthrough.preprocess.clean` makes demonstrations of them. Formats, names and columns are as
    for `read_demonstrations`.

    Args:
        paths: one file or folder, or several.
        columns: which columns, arrays or fields to read, by role.
        rate: Hz, > 0, for files without time.
        angles: unit of joints whose names don't state it.
        quaternions: order of four numbers whose names don't state it.
        topic: topic of a bag, where several have motions.
        frames: frame and child frame of a transform in a bag.
        joints: an arm's joints by name, with their lower and upper limits in rad (m). Columns of
            these names are its joints, whatever else the file has; percent refer to the limits.

    Raises:
        InvalidInput: if a file cannot be read; the message says which and where.
        MissingDependency: if the format needs an extra.
    """
    request = checked(
        columns=columns,
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=frames,
        joints=joints,
    )
    return [found for path in paths_of(paths) for _, found in _recordings(path, request)]


@contextmanager
def blaming(path: Path) -> Iterator[None]:
    """Puts a file's name before the errors that reading it leads to."""
    try:
        yield
    except OSError as error:
        raise InvalidInput(f"{printable(path)}: cannot be read ({error.strerror})") from None
    except InvalidInput as error:
        raise InvalidInput(f"{printable(path)}: {error}") from None


def printable(path: Path) -> str:
    """A path as text that can be printed, whatever bytes its name is made of."""
    text = str(path).encode("utf-8", "backslashreplace").decode()
    return text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)


def names_of(path: Path, tables: Sequence[Table]) -> list[str]:
    """The recordings' names: their own, or the file's, with [i] where it has several."""
    several = len(tables) > 1
    return [
        table.label or (f"{path.stem}[{i}]" if several else path.stem)
        for i, table in enumerate(tables)
    ]


def paths_of(paths: StrPath | Sequence[StrPath]) -> list[Path]:
    """One path or several, as a list."""
    several = [paths] if isinstance(paths, str | os.PathLike) else paths
    if not isinstance(several, Sequence) or not all(
        isinstance(path, str | os.PathLike) for path in several
    ):
        raise InvalidInput(f"paths: expected a path or a sequence of paths, got {paths!r}")
    if not several:
        raise InvalidInput("paths: expected at least one path, got none")
    return [Path(path) for path in several]


def _demonstrations(paths: Sequence[Path], request: Request) -> list[Demonstration]:
    """The demonstrations in files, whole."""
    return [
        Demonstration(_faultless(path, found, table, request), name=found.name)
        for path in paths
        for table, found in _recordings(path, request)
    ]


def _recordings(path: Path, request: Request) -> list[tuple[Table, Recording]]:
    with blaming(path):
        tables = formats.of_file(path).tables(path, request)
        return [
            (table, recording(table, request, name=name))
            for table, name in zip(tables, names_of(path, tables), strict=True)
        ]


def _faultless(path: Path, found: Recording, table: Table, request: Request) -> Motion:
    with blaming(path):
        try:
            return found.motion()
        except InvalidInput:
            check_complete(table, request)  # knows the place in the file
            raise
