"""Results of a command, as text for people or as JSON for machines."""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from types import MappingProxyType
from typing import Any

from rich import box
from rich.console import Console, Group
from rich.table import Table

_WIDTH = 80  # characters
_WHOLE_WORDS: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}


def table(rows: list[dict[str, Any]]) -> Group:
    """The rows as tables of 80 columns, transposed if that is narrower."""
    names = [name.replace("_", " ") for name in rows[0]] if rows else []
    lines = [names, *([_cell(value) for value in row.values()] for row in rows)]
    if len(names) > len(lines):
        lines = [list(line) for line in zip(*lines, strict=True)]
    return Group(*(_printed(part) for part in _narrow(lines)))


def _narrow(lines: list[list[str]]) -> Iterator[list[list[str]]]:
    """The lines cut into parts whose columns fit, each part behind the first column."""
    widths = [max(map(len, column)) + 1 for column in zip(*lines, strict=True)]
    first = 1
    while first < len(widths):
        last, used = first + 1, widths[0] + widths[first] + 1
        while last < len(widths) and used + widths[last] <= _WIDTH:
            used += widths[last]
            last += 1
        yield [[line[0], *line[first:last]] for line in lines]
        first = last
    if len(widths) == 1:
        yield lines


def _printed(lines: list[list[str]]) -> Table:
    # Words break where there is no room for a column; names with underscores do not.
    printed = Table(box=box.SIMPLE, padding=0, show_header=False)
    for line in lines:
        printed.add_row(*line)
    return printed


def facts(
    found: Mapping[str, Any], *, as_json: bool, units: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Prints a name and its value per line, or all as one JSON object."""
    if as_json:
        print(json.dumps(found, allow_nan=False))
        return
    width = max(map(len, found)) + 2
    for name, value in found.items():
        label = name.replace("_", " ")
        text = f"{label:<{width}}{_text(value)} {units.get(name, '')}".rstrip()
        print(textwrap.fill(text, _WIDTH, subsequent_indent=" " * width, **_WHOLE_WORDS))


def note(text: str) -> None:
    """Prints on stderr what a user may want to know of a result."""
    print(textwrap.fill(f"note: {text}", _WIDTH, **_WHOLE_WORDS), file=sys.stderr)


def busy(what: str) -> AbstractContextManager[Any]:
    """Shows on a terminal's stderr what is going on while the block runs."""
    return Console(stderr=True).status(what)


def _text(value: Any) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(_text, value)) or "none"
    return _cell(value)


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return "" if value is None else str(value)
