"""Reads a text table line by line into numbers, so that no more than these stay in memory."""

from __future__ import annotations

import csv
import json
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event
from leadthrough.io import bounds
from leadthrough.io.table import Table

EVENT = "# event,"  # begins the comment of an event

_DELIMITERS = ",;\t"

_BLOCK = 2**20  # bytes

# The text of a line and its number, counted from 1.
Line = tuple[int, str]


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
            raise InvalidInput(f"line {line}, column {name!r}: expected a number, got {cell!r}")
        return self.values[:, column].copy()

    def place(self, row: int) -> str:
        return f"line {self.lines[row]}"


def read(path: Path) -> TextTable:
    """The table in a file."""
    gate = bounds.Gate()
    count = _count_lines(path, gate)
    try:
        with path.open(encoding="utf-8-sig") as file:
            return _table(_lines(file), count, gate)
    except UnicodeDecodeError:
        raise bounds.not_text() from None


def _table(lines: Iterator[Line], count: int, gate: bounds.Gate) -> TextTable:
    events: list[Event] = []
    (start, header), first = _header(lines, events)
    delimiter = max(_DELIMITERS, key=header.count)
    gate.columns(header.count(delimiter) + 1, f"line {start}")
    names = _split(header, delimiter, start)
    name, times = Counter(names).most_common(1)[0]
    if times > 1:
        raise InvalidInput(f"line {start}: expected different column names, got {name!r} twice")
    gate.numbers(count * len(names), "the rows")
    rows = _Rows(names, delimiter)
    if first is not None:
        rows.add(*first)
    for number, line in lines:
        if line.startswith("#"):
            _collect_event(line, number, events)
        elif not line.isspace():
            rows.add(number, line)
    return rows.table(events)


class _Rows:
    """The numbers of the rows read so far."""

    def __init__(self, names: tuple[str, ...], delimiter: str) -> None:
        self._names, self._delimiter = names, delimiter
        self._values, self._lines = array("d"), array("q")
        self._faults: dict[int, Line] = {}

    def add(self, number: int, line: str) -> None:
        cells: Sequence[str] = line.split(self._delimiter)
        if '"' in line:
            cells = _split(line, self._delimiter, number)
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

    def _number(self, column: int, cell: str, number: int) -> float:
        text = cell.strip()
        if not text or column in self._faults:
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
        return TextTable(self._names, values, lines, self._faults, events=tuple(events))


def _count_lines(path: Path, gate: bounds.Gate) -> int:
    gate.bytes(path.stat().st_size, "the file")
    count = 1
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            count += block.count(b"\n") + block.count(b"\r")
    gate.items(2 * count, "the lines")  # each takes as long as two lists of a document
    return count


def _lines(file: TextIO) -> Iterator[Line]:
    """The lines of a file, none of which is read at once if it is too long."""
    number = 0
    while line := file.readline(bounds.MOST_LINE):
        number += 1
        if len(line) == bounds.MOST_LINE:
            raise InvalidInput(
                f"line {number}: expected fewer than {bounds.MOST_LINE:,} characters, got more"
            )
        yield number, line


def _header(lines: Iterator[Line], events: list[Event]) -> tuple[Line, Line | None]:
    """The row of names, and the first row of numbers if it has been read to find them."""
    comment: Line | None = None
    for number, line in lines:
        if line.startswith("#"):
            _collect_event(line, number, events)
            names = line.lstrip("# ")
            comment = (number, names) if names.strip() else comment
        elif line.strip() and not _starts_with_number(line):
            return (number, line), None
        elif line.strip():
            if comment is None:
                raise InvalidInput(f"line {number}: expected a header of column names, got numbers")
            return comment, (number, line)
    if comment is None:
        raise InvalidInput("expected a table with a header, got a file without rows")
    return comment, None


def _starts_with_number(line: str) -> bool:
    first = line
    for delimiter in _DELIMITERS:
        first = first.split(delimiter, 1)[0]
    try:
        float(first)
    except ValueError:
        return False
    return True


def _split(line: str, delimiter: str, number: int) -> tuple[str, ...]:
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
