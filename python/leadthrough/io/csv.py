"""Reads text tables: one sample a row, split at commas, semicolons or tabs, named by a header.

The header is the first row; it may follow or be a row that begins with `#`. Such rows are
comments everywhere else. A byte order mark and empty rows are skipped.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_DELIMITERS = ",;\t"


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

    def numbers(self, name: str) -> Float64Array:
        column = self.names.index(name)
        return np.array([_number(row, column, name) for row in self.rows])


def table(path: Path) -> CsvTable:
    """The table in a file. Raises InvalidInput."""
    try:
        lines = path.read_text(encoding="utf-8-sig").split("\n")
    except UnicodeDecodeError:
        raise InvalidInput("expected UTF-8 text") from None
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
    return CsvTable(names, tuple(rows))


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
    try:
        # Python takes 1_000 for a number; no recorder writes it.
        value = float("nan" if "_" in cell else cell)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise InvalidInput(
            f"line {row.line}, column {name!r}: expected a finite number, got {cell!r}"
        )
    return value
