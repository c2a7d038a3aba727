"""The files of a study: results.json, table.csv and figures."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from leadthrough.io.files import replacing
from leadthrough.show import page
from leadthrough.tasks import Row


def write(
    folder: Path,
    *,
    document: Mapping[str, Any],
    rows: Sequence[Row],
    tables: Mapping[str, Sequence[Row]],
    figures: Mapping[str, Figure],
    pages: Mapping[str, Sequence[str]],
) -> None:
    """Write results.json, the tables as <name>.csv, figures as <name>.png, pages as <name>.html.

    Args:
        folder: of the files; made if missing.
        document: content of results.json besides the rows.
        rows: all rows, for results.json.
        tables: tables by file stem, with the same columns in every row of one.
        figures: figures by file stem.
        pages: parts of HTML pages, as `leadthrough.show.page` makes them, by file stem.

    Raises:
        InvalidInput: if a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_text(folder / "results.json", _json(document, rows))
    for name, table in tables.items():
        write_table(folder / f"{name}.csv", table)
    for name, figure in figures.items():
        save_figure(figure, folder / f"{name}.png")
    for name, parts in pages.items():
        page.write_page(folder / f"{name}.html", name.replace("_", " ").capitalize(), parts)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as a PNG file, completely or not at all.

    Its parts keep the places that they get here, so that it is not laid out again for each file.
    """
    if engine := figure.get_layout_engine():
        engine.execute(figure)
        figure.set_layout_engine(None)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=110)


def _json(document: Mapping[str, Any], rows: Sequence[Row]) -> str:
    """The document with the rows as its last entry, one row per line."""
    head = json.dumps(document, indent=1, allow_nan=False).removesuffix("\n}")
    lines = ",\n".join(json.dumps(row, allow_nan=False) for row in rows)
    return f'{head},\n "rows": [\n{lines}\n]}}\n'


def write_table(path: Path, table: Sequence[Row]) -> None:
    columns = list(table[0]) if table else []
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


def _write_text(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
