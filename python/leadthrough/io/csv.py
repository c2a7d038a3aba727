"""Text tables: one sample per row, cells split at commas, semicolons or tabs, named by a header.

The header is the first row that is no comment; where that row is numbers, it is the last comment
before it. Comments begin with `#` and are skipped, except `# event,<time in s>,"<name>"`; so are
empty rows and a byte order mark.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event, Events
from leadthrough.io import bounds
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.io.joint_columns import checked_joint_names, joint_columns, quantities
from leadthrough.io.table import Table
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory

_DELIMITERS = ",;\t"
_EVENT = "# event,"


@dataclass(frozen=True, eq=False)
class Row:
    """The cells of a row and its line in the file, counted from 1."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class CsvTable(Table):
    """The cells of a text table; only columns that are asked for need to be numbers."""

    header: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def names(self) -> Sequence[str]:
        return self.header

    def numbers(self, name: str) -> Float64Array:
        column = self.header.index(name)
        return np.array([_number(row, column, name) for row in self.rows])

    def place(self, row: int) -> str:
        return f"line {self.rows[row].line}"


def table(path: Path) -> CsvTable:
    """The table in a file.

    Raises:
        InvalidInput: if there is no header, or rows are of different lengths.
    """
    lines = bounds.text(path).split("\n")
    header, start = _header(lines)
    delimiter = max(_DELIMITERS, key=header.count)
    names = _split(header, delimiter, start)
    name, times = Counter(names).most_common(1)[0]
    if times > 1:
        raise InvalidInput(f"line {start}: expected different column names, got {name!r} twice")
    rows = [
        Row(number, _split(line, delimiter, number))
        for number, line in enumerate(lines[start:], start + 1)
        if line.strip() and not line.startswith("#")
    ]
    for row in rows:
        if len(row.cells) != len(names):
            raise InvalidInput(
                f"line {row.line}: expected {len(names)} cells, as in the header, "
                f"got {len(row.cells)}"
            )
    if not rows:
        raise InvalidInput("expected rows of samples below the header, got none")
    return CsvTable(names, tuple(rows), events=_events(lines))


def write(motion: Motion, path: StrPath) -> None:
    """Writes one row per sample, to the last digit, with columns that reading finds by their names.

    These are `time` in s; `x`, `y`, `z` in m and `qw`, `qx`, `qy`, `qz`; or a joint's name for its
    position and, where the trajectory has them, `<name>_velocity` and `<name>_acceleration`.
    Events become comments.

    Args:
        motion: points of two or three coordinates, poses or joints with names.
        path: file to write.

    Raises:
        InvalidInput: if the points have other dimensions, the joints have no different, printable
            names, or the path cannot be written.
    """
    columns = _columns(motion)
    rows = np.column_stack([motion.times, *columns.values()])
    write_rows(path, ["time", *columns], rows, motion.events)


def write_rows(
    path: StrPath, header: Iterable[str], rows: Float64Array, events: Events = ()
) -> None:
    """Writes a table to the last digit, and a comment for each event.

    Args:
        path: file to write.
        header: names of k columns.
        rows: numbers (n, k).
        events: on the clock of the time column.

    Raises:
        InvalidInput: if the path cannot be written.
    """
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows.tolist())
        file.writelines(f"{_EVENT}{each.time!r},{json.dumps(each.name)}\n" for each in events)


def _events(lines: Sequence[str]) -> Events:
    found = []
    for number, line in enumerate(lines, 1):
        if line.startswith(_EVENT):
            time, _, name = line.removeprefix(_EVENT).partition(",")
            try:
                found.append(Event(float(time), json.loads(name)))
            except ValueError:
                raise InvalidInput(
                    f'line {number}: expected {_EVENT}<time>,"<name>", got {line[:60]!r}'
                ) from None
    return tuple(found)


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
    return columns


def _header(lines: Sequence[str]) -> tuple[str, int]:
    """The row of names and its line, counted from 1."""
    comment: tuple[str, int] | None = None
    for number, line in enumerate(lines, 1):
        if line.startswith("#"):
            names = line.lstrip("# ")
            comment = (names, number) if names.strip() else comment
        elif line.strip() and not _starts_with_number(line):
            return line, number
        elif line.strip():
            if comment is None:
                raise InvalidInput(f"line {number}: expected a header of column names, got numbers")
            return comment
    if comment is None:
        raise InvalidInput("expected a table with a header, got a file without rows")
    return comment


def _starts_with_number(line: str) -> bool:
    first = line
    for delimiter in _DELIMITERS:
        first = first.split(delimiter)[0]
    try:
        float(first)
    except ValueError:
        return False
    return True


def _split(line: str, delimiter: str, number: int) -> tuple[str, ...]:
    try:
        (cells,) = csv.reader([line], delimiter=delimiter, strict=True)
    except csv.Error as error:
        raise InvalidInput(f"line {number}: {error}") from None
    return tuple(cell.strip() for cell in cells)


def _number(row: Row, column: int, name: str) -> float:
    cell = row.cells[column]
    if not cell:
        return float("nan")
    try:
        # Python reads 1_000 as a number; no recorder writes it.
        return float("one" if "_" in cell else cell)
    except ValueError:
        raise InvalidInput(
            f"line {row.line}, column {name!r}: expected a number, got {cell!r}"
        ) from None
