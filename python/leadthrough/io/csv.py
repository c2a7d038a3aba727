"""Reads text tables: one sample a row, split at commas, semicolons or tabs, named by a header.

The header is the first row; it may follow or be a row that begins with `#`. Such rows are
comments everywhere else, but for `# event,<time in s>,"<name>"`. A byte order mark and empty rows
are skipped.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event, Events
from leadthrough.io import bounds
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.io.headers import Columns
from leadthrough.io.joint_names import checked_joint_names
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory

_DELIMITERS = ",;\t"
_EVENT = "# event,"


@dataclass(frozen=True, eq=False)
class Row:
    """A row's cells and its line in the file, from 1."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class CsvTable:
    """The cells of a text table; only columns that are asked for need to be numbers."""

    names: tuple[str, ...]
    rows: tuple[Row, ...]
    roles: Mapping[str, Columns] = field(default_factory=dict)
    label: str | None = None
    rate: float | None = None
    quaternions: str | None = None
    angles: str | None = None
    events: Events = ()

    def numbers(self, name: str) -> Float64Array:
        column = self.names.index(name)
        return np.array([_number(row, column, name) for row in self.rows])

    def place(self, row: int) -> str:
        return f"line {self.rows[row].line}"


def table(path: Path) -> CsvTable:
    """The table in a file. Raises InvalidInput."""
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
        raise InvalidInput("expected samples below the header, got none")
    return CsvTable(names, tuple(rows), events=_events(lines))


def write(motion: Motion, path: StrPath) -> None:
    """Writes one row a sample, to the last digit, with columns that reading finds by their names.

    `time` in s; `x`, `y`, `z` in m and `qw`, `qx`, `qy`, `qz`; or a joint's name for its position
    and, where the trajectory has them, `<name>_velocity` and `<name>_acceleration`. Comments tell
    the events.
    Raises InvalidInput for joints without different, printable names, points of more than three
    numbers and a path that cannot be written.
    """
    names, parts = _columns(motion)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time", *names])
        writer.writerows(np.column_stack([motion.times, *parts]).tolist())
        file.writelines(event_rows(motion.events))


def event_rows(events: Events) -> list[str]:
    """A comment for each event, with the name as JSON writes it."""
    return [f"{_EVENT}{event.time!r},{json.dumps(event.name)}\n" for event in events]


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


def _columns(motion: Motion) -> tuple[list[str], list[Float64Array]]:
    if not isinstance(motion, JointTrajectory):
        width = motion.positions.shape[1]
        if width not in (2, 3):
            raise InvalidInput(f"motion: expected points of two or three numbers, got {width}")
        if isinstance(motion, PoseTrajectory):
            return [*"xyz", "qw", "qx", "qy", "qz"], [motion.positions, motion.orientations]
        return list("xyz"[:width]), [motion.positions]
    joints = checked_joint_names(motion)
    names, parts = list(joints), [motion.positions]
    for quantity in ("velocity", "acceleration"):
        values = motion.velocities if quantity == "velocity" else motion.accelerations
        if values is not None:
            names += [f"{joint}_{quantity}" for joint in joints]
            parts.append(values)
    return names, parts


def _header(lines: Sequence[str]) -> tuple[str, int]:
    """The row of names and its line, from 1."""
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
        raise InvalidInput("expected a table with a header, got an empty file")
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
        # Python takes 1_000 for a number; no recorder writes it.
        return float("one" if "_" in cell else cell)
    except ValueError:
        raise InvalidInput(
            f"line {row.line}, column {name!r}: expected a number, got {cell!r}"
        ) from None
