"""Text tables: one sample per row, cells split at commas, semicolons, tabs or spaces, and a header.

A comma in a number is the decimal one if cells are split at anything else.

The header is the first row that is no comment; where that row is numbers, it is the last comment
before it. Of several rows above the first that begins with a number, those as wide as the last are
the header, its names joined and its units last; titles before are left out. A name above several
columns, as in merged cells, is of all of them, if they need it to differ. Comments begin with
`#` and are skipped, except `# event,<time in s>,"<name>"`; so are empty rows and a byte order mark.
Numbers of JointState messages (`rostopic echo -p`) are named by the joints in their cells. Files
are read in blocks, so that only numbers stay in memory.
"""

from __future__ import annotations

import codecs
import csv
import json
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import sanity
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io.files import MAX_LINE, ReadLimits, StrPath, not_text, replacing, written_blocks
from leadthrough.io.headers import JOINT_SUFFIXES, candidates, is_unit
from leadthrough.io.joint_trajectory import checked_joint_names, joint_columns, quantities
from leadthrough.io.recording import demonstrated_columns
from leadthrough.io.table import Table
from leadthrough.motion import Event, Events, JointTrajectory, Motion, PoseTrajectory

EVENT = "# event,"  # begins the comment of an event
_DELIMITERS = ",;\t"
_SPACES = " "  # any number of them, where a header has none of the delimiters
_BETWEEN = re.compile(r"\s+(?![\[(])")  # cells: a unit in brackets belongs to the name before
# Cells without a number, besides empty ones and "nan".
_MISSING = {"", "na", "n/a", "#n/a", "none", "null", "-", "--"}
# In columns of JointState messages, such as field.name0 with the joint of field.position0.
_NAME = re.compile(r"name(?=[_.\[]?\d+\]?$)")
_BLOCK = 2**20  # bytes
_MAX_HEAD = 12  # rows of titles, names and units
# The text of a line and its number, counted from 1.
Line = tuple[int, str]


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
        csv.writer(file, lineterminator="\n").writerow(header)
        layout = core.RecordLayout(["", "\n"], [rows.shape[1]], ",")
        file.writelines(written_blocks(rows, layout))
        file.writelines(f"{EVENT}{each.time!r},{json.dumps(each.name)}\n" for each in events)


def _columns(motion: Motion) -> dict[str, Float64Array]:
    if isinstance(motion, JointTrajectory):
        columns = joint_columns(checked_joint_names(motion), quantities(motion))
        found = candidates([*columns])
        read = set().union(*found["joints"])
        if (read or found["positions"]) and not read.issuperset(motion.joint_names or ()):
            sanity.warn("motion: not all joints are told by their names here; .npz keeps them all")
        return columns
    width = motion.positions.shape[1]
    if width not in (2, 3):
        raise InvalidInput(
            f"motion: expected points of two or three coordinates, got {width}; .npz takes any"
        )
    columns = dict(zip("xyz", motion.positions.T, strict=False))
    if isinstance(motion, PoseTrajectory):
        columns |= dict(zip(("qw", "qx", "qy", "qz"), motion.orientations.T, strict=True))
    return columns | demonstrated_columns(motion)


@dataclass(frozen=True, eq=False)
class TextTable(Table):
    """The numbers of a text table; only columns that are asked for need to be numbers."""

    header: tuple[str, ...]  # the names of the columns
    values: Float64Array  # a row per sample, NaN for cells that are empty or no numbers
    lines: NDArray[np.int64]  # the line of each row in the file, counted from 1
    faults: Mapping[int, Line]  # the first cell that is no number, by column: its line and text

    @property
    def names(self) -> Sequence[str]:
        return self.header

    def numbers(self, name: str) -> Float64Array:
        column = self.header.index(name)
        if column in self.faults:
            line, cell = self.faults[column]
            cure = "; put each number in a column of its own" if cell[0] in "[(" else ""
            cure = "; give the rate in Hz for clocks of text, rate=100" if ":" in cell else cure
            raise InvalidInput(
                f"line {line}, column {name!r}: expected a number, got {cell!r}{cure}"
            )
        return self.values[:, column].copy()

    def place(self, row: int) -> str:
        return f"line {self.lines[row]}"


def read_table(path: Path) -> TextTable:
    limits = ReadLimits()
    count = _count_lines(path, limits)
    try:
        with path.open(encoding=_encoding(path)) as file:
            return _table(file, count, limits)
    except UnicodeDecodeError:
        raise not_text() from None


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        mark = file.read(2)
    return "utf-16" if mark in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else "utf-8-sig"


def _table(file: TextIO, count: int, limits: ReadLimits) -> TextTable:
    events: list[Event] = []
    head, first = _header(_lines(file, 0), events)
    start, header = head[-1]
    delimiter = _delimiter(header)
    limits.columns(header.count(delimiter) + 1, f"line {start}")
    names = _names([_split(line, delimiter, number) for number, line in head])
    if name := next((name for name, times in Counter(names).items() if name and times > 1), ""):
        raise InvalidInput(f"line {start}: expected different column names, got {name!r} twice")
    limits.numbers(count * len(names), "the rows")
    rows = _Rows(names, delimiter)
    number = start
    for number, line in first:
        rows.add(number, line)
    layout = core.RecordLayout(["", "\n"], [len(names)], delimiter)
    while text := file.read(_BLOCK) + file.readline(MAX_LINE):
        values, length = core.read_records(block := text.encode(), layout)
        rows.extend(number + 1, values)
        read = number + len(values) // len(names)
        behind = StringIO(block[length:].decode())
        for number, line in _lines(behind, read):
            if line.startswith("#"):
                _collect_event(line, number, events)
            elif not line.isspace():
                rows.add(number, line)
        number = read + block.count(b"\n", length)
    return rows.table(events)


class _Rows:
    """The numbers of the rows read so far."""

    def __init__(self, names: tuple[str, ...], delimiter: str) -> None:
        self._names, self._delimiter = names, delimiter
        self._values, self._lines = array("d"), array("q")
        self._faults: dict[int, Line] = {}
        self._changing: set[int] = set()  # columns of more than one text

    def add(self, number: int, line: str) -> None:
        if self._delimiter != ",":
            line = line.replace(",", ".")
        if self._delimiter == _SPACES or '"' in line:
            cells: Sequence[str] = _split(line, self._delimiter, number)
        else:
            cells = line.split(self._delimiter)
        if len(cells) != len(self._names):
            raise InvalidInput(
                f"line {number}: expected {len(self._names)} cells, as in the header, "
                f"got {len(cells)}"
            )
        self._lines.append(number)
        try:
            if "_" in line:  # Python reads 1_000 as a number; no recorder writes it
                raise ValueError
            self._values.extend(list(map(float, cells)))
        except ValueError:
            self._values.extend([self._number(i, cell, number) for i, cell in enumerate(cells)])

    def extend(self, number: int, values: Float64Array) -> None:
        """Adds rows of plain numbers, the first of which is a line of this number."""
        self._values.frombytes(values.tobytes())
        count = len(values) // len(self._names)
        self._lines.frombytes(np.arange(number, number + count).tobytes())

    def _number(self, column: int, cell: str, number: int) -> float:
        text = cell.strip()
        missing = text.lower() in _MISSING
        if missing or column in self._faults:
            if not missing and text != self._faults[column][1]:
                self._changing.add(column)
            return np.nan
        try:
            return float("one" if "_" in text else text)
        except ValueError:
            self._faults[column] = number, text
            return np.nan

    def table(self, events: Sequence[Event]) -> TextTable:
        if not self._lines:
            raise InvalidInput("expected rows of samples below the header, got none")
        values = np.frombuffer(self._values).reshape(len(self._lines), len(self._names))
        lines = np.frombuffer(self._lines, np.int64)
        return TextTable(self._joints_named(), values, lines, self._faults, events=tuple(events))

    def _joints_named(self) -> tuple[str, ...]:
        """The columns' names; those of a JointState's numbers after the joints in its names."""
        renamed = {}
        for column in self._faults.keys() - self._changing:
            name, joint = self._names[column], self._faults[column][1]
            if _NAME.search(name):
                renamed[_NAME.sub("position", name)] = joint
                renamed[_NAME.sub("velocity", name)] = joint + JOINT_SUFFIXES["velocities"]
        found = tuple(renamed.get(name, name) for name in self._names)
        return found if len(set(found)) == len(found) else self._names


def _count_lines(path: Path, limits: ReadLimits) -> int:
    limits.streamed(path)
    count = 1
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            count += block.count(b"\n") + block.count(b"\r")
    limits.items(2 * count, "the lines")  # each takes as long as two lists of a document
    return count


def _lines(file: TextIO, number: int) -> Iterator[Line]:
    """The lines behind one of this number, none of which is read at once if it is too long."""
    while line := file.readline(MAX_LINE):
        number += 1
        if len(line) == MAX_LINE:
            raise InvalidInput(
                f"line {number}: expected fewer than {MAX_LINE:,} characters, got more"
            )
        yield number, line


def _header(lines: Iterator[Line], events: list[Event]) -> tuple[list[Line], list[Line]]:
    """The rows of names, and the rows below them that have been read to find them."""
    comment: Line | None = None
    texts: list[Line] = []
    for number, line in lines:
        if line.startswith("#"):
            _collect_event(line, number, events)
            names = line.lstrip("# ")
            comment = (number, names) if names.strip() else comment
        elif line.strip() and not _starts_with_number(line):
            texts.append((number, line))
            if len(texts) == _MAX_HEAD or (len(texts) == 2 and _has_numbers(*texts)):
                break
        elif line.strip() and texts:
            return _divided(texts, (number, line))
        elif line.strip():
            if comment is None:
                delimiter = _delimiter(line)
                count, such = len(_split(line, delimiter, number)), ("time", "joint_1", "joint_2")
                raise InvalidInput(
                    f"line {number}: expected a header of column names, got {count} numbers; put "
                    f"as many names above, such as {delimiter.join(such)}; a row is a sample"
                )
            return [comment], [(number, line)]
    if texts:
        return texts[:1], texts[1:]
    if comment is None:
        raise InvalidInput("expected a table with a header, got a file without rows")
    return [comment], []


def _divided(texts: list[Line], row: Line) -> tuple[list[Line], list[Line]]:
    """The rows of names above the first one of numbers, and the others below the first."""
    delimiter = _delimiter(texts[-1][1])
    widths = [  # as many as the cells, or one less, whatever their quotes
        len(_BETWEEN.split(line.strip())) if delimiter == _SPACES else line.count(delimiter)
        for _, line in [*texts, row]
    ]
    if widths[-1] != widths[-2]:
        return [texts[0]], [*texts[1:], row]
    others = [i for i, width in enumerate(widths) if width != widths[-1]]
    return texts[others[-1] + 1 if others else 0 :], [row]


def _has_numbers(header: Line, row: Line) -> bool:
    """Whether a row that begins with text is one of the header's samples all the same."""
    cells = _split(row[1], _delimiter(header[1]), row[0])
    return any(map(_starts_with_number, cells)) or not any(cells)


def _names(rows: list[tuple[str, ...]]) -> tuple[str, ...]:
    """The columns' names from the rows of a header, each with the unit that the last may state."""
    *above, last = rows
    units = above and all(is_unit(cell) for cell in last if cell)
    *titles, lowest = above if units else rows
    parts = zip(*(_titled(row, lowest) for row in titles), lowest, strict=True)
    names = ["_".join(filter(None, cells)) for cells in parts]
    if not units:
        return tuple(names)
    return tuple(
        f"{name} [{u.strip('[]()')}]" if u else name for name, u in zip(names, last, strict=True)
    )


def _titled(titles: tuple[str, ...], names: tuple[str, ...]) -> list[str]:
    """The title above each name: of a row with gaps only where names of its columns need it."""
    if all(titles):
        return [*titles]
    spread = list[str]()
    for title in titles:
        spread.append(title or (spread[-1] if spread else ""))
    often = Counter(names)
    needed = {title for title, name in zip(spread, names, strict=True) if often[name] > 1}
    return [title if title in needed else "" for title in spread]


def _delimiter(header: str) -> str:
    found = max(_DELIMITERS, key=header.count)
    return found if found in header else _SPACES


def _starts_with_number(line: str) -> bool:
    try:
        float(re.split(r"[,;\s]", line.strip(), maxsplit=1)[0])
    except ValueError:
        return False
    return True


def _split(line: str, delimiter: str, number: int) -> tuple[str, ...]:
    if delimiter == _SPACES:
        return tuple(_BETWEEN.split(line.strip()))
    try:
        (cells,) = csv.reader([line.rstrip("\n")], delimiter=delimiter, strict=True)
    except csv.Error as error:
        raise InvalidInput(f"line {number}: {error}") from None
    return tuple(cell.strip() for cell in cells)


def _collect_event(line: str, number: int, events: list[Event]) -> None:
    if not line.startswith(EVENT):
        return
    time, _, name = line.removeprefix(EVENT).partition(",")
    try:
        events.append(Event(float(time), json.loads(name)))
    except (ValueError, RecursionError):
        raise InvalidInput(
            f'line {number}: expected {EVENT}<time>,"<name>", got {line.strip()[:60]!r}'
        ) from None
