"""Reads recordings and demonstrations from files of any format.

Large data sets are streamed in bounded memory: a LeRobot data set one file at a time, a robomimic
file some demonstrations at a time. Unreadable episodes are reported and skipped.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from leadthrough import check, sanity
from leadthrough.check import InvalidInput, ShortRepr
from leadthrough.io import formats, lerobot, reader_process, robomimic
from leadthrough.io.files import StrPath
from leadthrough.io.headers import AngleUnit, QuaternionOrder
from leadthrough.io.recording import CLEANED, Recording, check_complete, lost, recording
from leadthrough.io.table import Ranges, Request, Table, as_request
from leadthrough.motion import Demonstration, Motion
from leadthrough.rest import trim

_AT_A_TIME = 20  # demonstrations of a robomimic file
# Signs of a motion in the beginning of a file: numbers in a row, or the name of its points.
_HEAD, _POINTS = 65_536, re.compile(r"\bpoints\b")
_ROW = re.compile(r"""(^|[,;\s"'])[-+.]?\d[^\s,;]*(\s*[,;]\s*|\s+)["']?[-+.]?\d""", re.MULTILINE)
_SIGNS = {".txt": _ROW, ".json": _POINTS, ".yaml": _POINTS, ".yml": _POINTS}


def read_demonstrations(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: AngleUnit | None = None,
    quaternions: QuaternionOrder | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
    joints: Ranges | None = None,
    rest: float = 0.0,
) -> list[Demonstration]:
    """The demonstrations in one or several files, in their order; files with faults are refused.

    Rest before and after the motion is left out, as `preprocess.trim` does; times
    are as in the file. `read_motion` reads a motion that an arm is to run, whole.

    Formats are text tables (.csv, .tsv, .txt), NumPy's .npz and .npy, .mat, ROS 2 JointTrajectory
    (.json, .yaml), ROS bags (.bag, .mcap, .db3 or a folder; extra `ros`), robomimic (.hdf5; extra
    `hdf5`) and LeRobot (.parquet or a folder; extra `lerobot`). A demonstration is named as in the
    file, or else after it, with [i] where the file has several.

    Joints make a JointTrajectory, positions and orientations a PoseTrajectory, positions alone a
    Trajectory. A motion and a time (s) that `columns` does not name are found by the names in the
    file, which `leadthrough.io.headers` lists.

    Args:
        paths: one file or folder, or several. Of a folder of recordings all are read, by name.
        columns: columns, arrays or fields to read, any of {"time": name, "positions":
            [names], "orientations": [names], "joints": [names]}; * and ? in a name stand for
            any characters and for one.
        rate: Hz, > 0, for files without time; their first sample is then at 0 s.
        angles: unit of joints whose names don't state it, by default radians. Joints that stay
            beyond two turns are refused until it is set. "percent" of the joints' ranges, as in
            LeRobot's data sets, go from -100 to 100, of a gripper from 0 to 100.
        quaternions: order of four numbers whose names don't state it.
        topic: topic of a bag, where several have motions.
        frames: frame and child frame of a transform in a bag.
        joints: an arm's joints by name, with (lower, upper) limits in rad, or (lower, upper, "m")
            for prismatic ones, which stay in m where `angles` are degrees. Columns of
            these names are its joints, whatever else the file has; as many in `columns` are those
            in their names, or else all in this order. Percent refer to the limits.
        rest: s of standing still to keep before and after, >= 0; `math.inf` keeps all of it.

    Raises:
        InvalidInput: if a file cannot be read or has faults; the message says which and where.
        MissingDependency: if the format needs an extra.
    """
    request = as_request(columns, rate, angles, quaternions, topic, frames=frames, joints=joints)
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
    joints: Ranges | None = None,
) -> Motion:
    """The only motion in a file, whole, as `write_motion` writes it.

    Formats, names and columns are as for `read_demonstrations`.

    Args:
        columns, rate, angles, quaternions, topic, frames, joints: as of `read_demonstrations`.

    Raises:
        InvalidInput: if the file cannot be read, has faults, or has not exactly one motion.
        MissingDependency: if the format needs an extra.
    """
    request = as_request(columns, rate, angles, quaternions, topic, frames=frames, joints=joints)
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected the path of one file or folder, got {path!r}")
    found = _demonstrations([Path(path)], request)
    if len(found) != 1:
        raise check.refused(printable(Path(path)), "a file with one motion", len(found))
    sanity.clock(found[0].motion.times, printable(Path(path)))
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
    joints: Ranges | None = None,
) -> list[Recording]:
    """The recordings in one or several files, with missing numbers and faulty times as they are.

    `leadthrough.preprocess.clean` makes demonstrations of them. Formats, names and columns are as
    for `read_demonstrations`.

    Args:
        paths: one file or folder, or several.
        columns, rate, angles, quaternions, topic, frames, joints: as of `read_demonstrations`.

    Raises:
        InvalidInput: if a file cannot be read; the message says which and where.
        MissingDependency: if the format needs an extra.
    """
    request = as_request(columns, rate, angles, quaternions, topic, frames=frames, joints=joints)
    return [found for path in paths_of(paths) for _, found in _recordings(path, request)]


@contextmanager
def blaming(path: Path) -> Iterator[None]:
    """Puts a file's name before the errors that reading it leads to."""
    try:
        with check.prefixed(printable(path)):
            yield
    except OSError as error:
        raise InvalidInput(f"{printable(path)}: cannot be read ({error.strerror})") from None


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


def listed(paths: Sequence[Path], *, also: Sequence[str] = ()) -> list[Path]:
    """The paths, with the recordings in a folder, by their names, instead of the folder."""
    files = []
    for path in paths:
        # Path.is_dir raises for a name that is too long.
        is_folder = os.path.isdir(path)  # noqa: PTH112
        found = _inside(path, also) if is_folder and not can_read(path) else [path]
        if not found:
            raise InvalidInput(
                f"{path}: nothing to read in this folder; name one with recordings, such as .csv, "
                ".npz or .mcap files"
            )
        files += found
    return files


def _inside(folder: Path, also: Sequence[str]) -> list[Path]:
    return [
        path
        for path in sorted(folder.iterdir())
        if not path.name.startswith(".")
        and (
            (can_read(path) and not _is_note(path))
            or (path.is_file() and path.suffix.lower() in also)
        )
    ]


def _is_note(path: Path) -> bool:
    """Whether a file has the suffix of a motion and nothing of one in it: a text, or settings."""
    sign = _SIGNS.get(path.suffix.lower())
    if sign is None or path.is_dir():
        return False
    with blaming(path), path.open(encoding="utf-8", errors="replace") as file:
        # Without the zeros between the letters of UTF-16.
        return sign.search(file.read(_HEAD).replace("\0", "")) is None


def can_read(path: Path) -> bool:
    """Whether a file or folder is there whose format can be read."""
    try:
        formats.of_file(path)
    except InvalidInput:
        return False
    return True


def _demonstrations(paths: Sequence[Path], request: Request) -> list[Demonstration]:
    """The demonstrations in files, whole."""
    return [
        Demonstration(_faultless(path, found, table, request), name=found.name)
        for path in listed(paths)
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
            motion = found.motion()
        except InvalidInput as error:
            check_complete(table, request)  # knows the place in the file
            cure = CLEANED if error.argument in ("times", "orientations") else ""
            raise InvalidInput(f"{error}{cure}") from None
        if (gone := lost(motion.positions)).any():
            row = int(gone.argmax())
            seen = "stands still and then leaps" if motion.positions[row].any() else "is 0, far off"
            raise InvalidInput(
                f"{table.place(row)}: the position {seen}, as of a tracker "
                f"without a target{CLEANED}"
            )
        return motion


@dataclass(frozen=True, eq=False)
class Episode(ShortRepr):
    """One recording of a data set, or why it cannot be read.

    Attributes:
        name: of the recording; of a file that cannot be read, the file's.
        recording: with missing numbers and faulty times as they are; None if it cannot be read.
        problem: why it cannot; empty if it can.
    """

    name: str
    recording: Recording | None
    problem: str = ""


def stream_recordings(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
    angles: AngleUnit | None = None,
    quaternions: QuaternionOrder | None = None,
    topic: str | None = None,
    frames: Sequence[str] | None = None,
    joints: Ranges | None = None,
) -> Iterator[Episode]:
    """The recordings in files, one after the other; unreadable ones are skipped.

    As `read_recordings`, for data sets that do not fit into memory, or have damaged episodes: of a
    LeRobot data set one file is in memory at a time, of a robomimic file 20 demonstrations.

    Args:
        paths: one file or folder, or several.
        columns, rate, angles, quaternions, topic, frames, joints: as of `read_demonstrations`.

    Yields:
        An episode for each recording.

    Raises:
        MissingDependency: if the format needs an extra.
    """
    request = as_request(columns, rate, angles, quaternions, topic, frames=frames, joints=joints)
    for path in paths_of(paths):
        try:
            with blaming(path):
                parts = _parts(path)
        except InvalidInput as error:
            yield Episode(path.name, None, str(error))
            continue
        for part in parts:
            yield from _episodes(path, part, request)


@dataclass(frozen=True)
class _Part:
    """A part of a file or folder that is read at a time."""

    file: Path  # the file or folder
    names: tuple[str, ...] = ()
    first: int = 0  # index of the first of them
    extents: tuple[tuple[str, lerobot.Extent], ...] = ()  # of motors in the whole data set


def _parts(path: Path) -> list[_Part]:
    """The parts of a file or folder, to be read one after the other."""
    name = formats.of_file(path).name
    if name == "lerobot" and path.is_dir():
        reader_process.require("pyarrow.parquet", extra="lerobot")
        files = lerobot.files(path)
        extents = tuple(_motor_extents(path, files).items())
        return [_Part(file, extents=extents) for file in files]
    if name == "robomimic":
        reader_process.require("h5py", extra="hdf5")
        names = tuple(reader_process.plain(robomimic.labels, path))
        return [
            _Part(path, names[first : first + _AT_A_TIME], first)
            for first in range(0, len(names), _AT_A_TIME)
        ]
    return [_Part(path)]


def _motor_extents(path: Path, files: Sequence[Path]) -> dict[str, lerobot.Extent]:
    """The extents of motors in all files, where the data set does not state them."""
    if not lerobot.lacks_extents(path):
        return {}
    found: dict[str, lerobot.Extent] = {}
    for file in files:
        try:
            tables = reader_process.tables(lerobot.tables, file)
        except InvalidInput:  # reported with its episodes
            continue
        for name, (least, most) in tables[0].extents.items() if tables else ():
            before = found.get(name, (least, most))
            found[name] = (min(least, before[0]), max(most, before[1]))
    return found


def _episodes(path: Path, part: _Part, request: Request) -> Iterator[Episode]:
    """The episodes of a part; where it cannot be read as a whole, of each by itself."""
    try:
        with blaming(part.file):
            tables = _tables(path, part, request)
    except InvalidInput as error:
        if len(part.names) < 2:
            yield Episode((part.names or (part.file.stem,))[0], None, str(error))
            return
        for i, name in enumerate(part.names):
            yield from _episodes(path, _Part(part.file, (name,), part.first + i), request)
        return
    for table, name in zip(tables, names_of(part.file, tables), strict=True):
        try:
            yield Episode(name, recording(table, request, name=name))
        except InvalidInput as error:
            yield Episode(name, None, str(error))


def _tables(path: Path, part: _Part, request: Request) -> Sequence[Table]:
    if part.names:
        some = replace(request, part=(part.first, part.first + len(part.names)))
        return reader_process.tables(robomimic.tables, part.file, some)
    if part.file == path:
        return formats.of_file(path).tables(path, request)
    tables = reader_process.tables(lerobot.tables, part.file)
    if not part.extents:
        return tables
    return [lerobot.of_motors(table, dict(part.extents)) for table in tables]
