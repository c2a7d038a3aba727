"""Results of a command, as text for people or as JSON for machines."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table


def table(rows: list[dict[str, Any]]) -> Table:
    """A table of the rows; transposed if that is narrower."""
    # Words break where there is no room for a column; names with underscores do not.
    names = [name.replace("_", " ") for name in rows[0]] if rows else []
    lines = [names, *(list(row.values()) for row in rows)]
    if len(names) > len(lines):
        lines = [list(line) for line in zip(*lines, strict=True)]
    printed = Table(box=box.SIMPLE, padding=0, show_header=False)
    for line in lines:
        printed.add_row(*map(_cell, line))
    return printed


def facts(found: Mapping[str, Any], *, as_json: bool) -> None:
    """Prints a name and its value per line, or all as one JSON object."""
    if as_json:
        print(json.dumps(found, allow_nan=False))
        return
    width = max(map(len, found)) + 2
    for name, value in found.items():
        label = name.replace("_", " ")
        print(f"{label:<{width}}{_text(value)}")


def busy(what: str) -> AbstractContextManager[Any]:
    """Shows on a terminal's stderr what is going on while the block runs."""
    return Console(stderr=True).status(what)


def _text(value: Any) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(_text, value)) or "none"
    return _cell(value)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return "" if value is None else str(value)
