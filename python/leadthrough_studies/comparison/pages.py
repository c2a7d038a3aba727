"""The page of the comparison: its tables and the pictures of every motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from leadthrough.show import page
from leadthrough_studies.comparison.rivals import NOT_INSTALLED
from leadthrough_studies.study import Row, selected

_CAPTIONS = {
    "figure_16": "Figure 16 anew: the way without experience and with it",
    "figure_17": "Figure 17 anew: the velocity map of one demonstration and of all",
    "figure_18": "Figure 18 as computed: states, actions and values of the decision process",
    "stability": "Trajectories of the systems from all around, and levels of their energies",
}
_TITLES = {"LOO": "Handwriting, left out", "IN": "Handwriting, left in"}


def page_parts(
    table: Sequence[Row], summary: Mapping[str, Any], figures: Mapping[str, Figure]
) -> list[str]:
    """The parts of the page, in their order.

    Args:
        table: the table of the report.
        summary: its summary.
        figures: its figures.
    """
    parts = []
    for part in dict.fromkeys(row["part"] for row in table):
        own = selected(table, part=part)
        parts += [
            page.heading(_TITLES.get(part, f"Left out, start and goal given: {part}")),
            _table(own),
        ]
    for title, name in (
        ("Stability of the dynamical systems", "stability"),
        ("Table 2 of Prados et al. 2023, anew", "table_2"),
        ("Table 1 of Prados et al. 2023, anew", "table_1"),
    ):
        if summary[name]:
            parts += [page.heading(title), _table(summary[name])]
    parts.append(page.text(summary["remark"]))
    if summary["not_installed"]:
        parts.append(page.text(NOT_INSTALLED.format(", ".join(summary["not_installed"]))))
    captions = {"errors": "Means of all methods, left out and left in", **_CAPTIONS}
    caption = "The first drawing of each motion, left out, and what the methods make of it"
    parts += [page.figure(each, captions.get(name, caption)) for name, each in figures.items()]
    return parts


def _table(rows: Sequence[Row]) -> str:
    """A table of the columns that have a value in any row."""
    names = [name for name in rows[0] if any(row[name] is not None for row in rows)]
    names = [name for name in names if name != "part"]
    return page.table(
        [name.replace("_", " ") for name in names],
        [[_cell(row[name]) for name in names] for row in rows],
    )


def _cell(value: Any) -> object:
    if isinstance(value, list):
        return ", ".join(str(each) for each in value)
    if isinstance(value, float):
        return f"{value:.3g}"
    return "" if value is None else value
