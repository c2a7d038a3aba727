"""The recordings of large data sets, one after the other, in bounded memory.

A LeRobot data set is read one file at a time, a robomimic file some demonstrations at a time. What
cannot be read is told and passed over.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from leadthrough.errors import InvalidInput
from leadthrough.io import apart, formats, lerobot, robomimic
from leadthrough.io.atomic import StrPath
from leadthrough.io.columns import recording
from leadthrough.io.headers import AngleUnit, QuaternionOrder
from leadthrough.io.reading import blaming, names_of, paths_of
from leadthrough.io.recording import Recording
from leadthrough.io.request import Request, checked
from leadthrough.io.table import Table
from leadthrough.repr import ShortRepr

_AT_A_TIME = 20  # demonstrations of a robomimic file


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
    joints: Mapping[str, tuple[float, float]] | None = None,
) -> Iterator[Episode]:
    """The recordings in files, one after the other; what cannot be read is passed over.

    As `read_recordings`, for data sets that do not fit into memory, or have damaged episodes: of a
    LeRobot data set one file is in memory at a time, of a robomimic file 20 demonstrations.

    Args:
        paths: one file or folder, or several.
        columns: which columns, arrays or fields to read, by role.
        rate: Hz, > 0, for files without time.
        angles: unit of joints whose names don't state it.
        quaternions: order of four numbers whose names don't state it.
        topic: topic of a bag, where several have motions.
        frames: frame and child frame of a transform in a bag.
        joints: an arm's joints by name, with their lower and upper limits in rad (m).

    Yields:
        An episode for each recording.

    Raises:
        InvalidInput: if an argument is wrong.
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
    """What is read at a time."""

    file: Path  # the file or folder
    names: tuple[str, ...] = ()
    first: int = 0  # index of the first of them
    extents: tuple[tuple[str, lerobot.Extent], ...] = ()  # of motors in the whole data set


def _parts(path: Path) -> list[_Part]:
    """What of a file or folder is read one after the other."""
    name = formats.of_file(path).name
    if name == "lerobot" and path.is_dir():
        apart.require("pyarrow.parquet", extra="lerobot")
        files = lerobot.files(path)
        extents = tuple(_motor_extents(path, files).items())
        return [_Part(file, extents=extents) for file in files]
    if name == "robomimic":
        apart.require("h5py", extra="hdf5")
        names = tuple(apart.plain(robomimic.labels, path))
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
            tables = apart.tables(lerobot.tables, file)
        except InvalidInput:  # told when its episodes are due
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
        return apart.tables(robomimic.tables, part.file, some)
    if part.file == path:
        return formats.of_file(path).tables(path, request)
    tables = apart.tables(lerobot.tables, part.file)
    if not part.extents:
        return tables
    return [lerobot.of_motors(table, dict(part.extents)) for table in tables]
