"""Rows of numbers as text."""

from __future__ import annotations

from typing import Any

from rich import box
from rich.table import Table


def table(rows: list[dict[str, Any]]) -> Table:
    """The rows; as columns where that is narrower."""
    # Words break where there is no room for a column; names with underscores do not.
    names = [name.replace("_", " ") for name in rows[0]] if rows else []
    lines = [names, *(list(row.values()) for row in rows)]
    if len(names) > len(lines):
        lines = [list(line) for line in zip(*lines, strict=True)]
    table = Table(box=box.SIMPLE, padding=0, show_header=False)
    for line in lines:
        table.add_row(*map(_cell, line))
    return table


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return "" if value is None else str(value)
