"""The table of docs/speed.md: made from a run, and compared with one."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from frame import Row

HEAD = "| problem | peer | times faster |\n|---|---|---|\n"
BETTER = 1.15  # how much better than measured a printed figure may be
_LINES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text())["row"]
_NUMBER = r"(\d+(?:\.\d+)?)"
_RANGE = _NUMBER + f"(?: to {_NUMBER})?"


@dataclass(frozen=True)
class Figure:
    """The measured value behind one placeholder of a line."""

    low: float
    high: float
    more_is_better: bool = True

    def too_good(self, printed: Sequence[str | None]) -> bool:
        """Whether what is printed, one number or two, is better than measured."""
        low, high = (float(text or printed[0] or 0.0) for text in (printed[0], printed[-1]))
        if self.more_is_better:
            return low > BETTER * self.low or high > BETTER * self.high
        return BETTER * low < self.low

    def __str__(self) -> str:
        """The figure as it is printed."""
        ends = list(dict.fromkeys(map(_rounded, (self.low, self.high))))
        return " to ".join(ends)


def table(rows: Sequence[Row]) -> str:
    """The table in Markdown, of the rows of a complete run."""
    lines = []
    for line in _LINES:
        figures = _figures(line, rows)
        cells = (_filled(line[cell], figures) for cell in ("problem", "peer", "faster"))
        lines.append(f"| {' | '.join(cells)} |\n")
    return HEAD + "".join(lines)


def too_good(text: str, rows: Sequence[Row]) -> list[str]:
    """Figures of a page's table that the rows of a complete run do not show, a line each.

    Args:
        text: the page.
        rows: of the run.
    """
    _, _, body = text.partition(HEAD)
    printed = re.findall(r"^\| .* \|$", body.split("\n\n")[0].split("<!--")[0], re.MULTILINE)
    faults = [
        f"{len(printed)} rows are printed, {len(_LINES)} are described in printed.toml"
        for _ in range(len(printed) != len(_LINES))
    ]
    for line, row in zip(_LINES, printed, strict=False):
        faults += _faults(line, _figures(line, rows), row)
    return faults


def _faults(line: dict[str, Any], figures: dict[str, Figure], printed: str) -> list[str]:
    pattern = re.escape(f"| {line['problem']} | {line['peer']} | {line['faster']} |")
    order = re.findall(r"\\\{(\w+)\\\}", pattern)
    match = re.fullmatch(re.sub(r"\\\{\w+\\\}", lambda _: _RANGE, pattern), printed)
    if match is None:
        return [f"not as printed.toml has it: {printed}"]
    numbers = match.groups()
    pairs = {name: numbers[2 * i : 2 * i + 2] for i, name in enumerate(order)}
    return [
        f"{line['problem']}: {pair[0]} is printed, {figures[name]} measured"
        for name, pair in pairs.items()
        if figures[name].too_good(pair)
    ]


def _figures(line: dict[str, Any], rows: Sequence[Row]) -> dict[str, Figure]:
    """By placeholder."""
    figures = {}
    for i, pattern in enumerate(line["of"]):
        ratios = [row.ratio or 0.0 for row in _matching(pattern, rows)]
        figures[str(i)] = Figure(min(ratios), max(ratios))
    error = max(row.error for row in _matching(line["of"][0], rows))
    figures["error"] = Figure(error, error, more_is_better=False)
    figures["longer"] = Figure(1.0 + error, 1.0 + error, more_is_better=False)
    return figures


def _matching(pattern: str, rows: Sequence[Row]) -> list[Row]:
    name, _, peer = pattern.partition("@")
    found = [
        row for row in rows if fnmatchcase(row.name, name) and fnmatchcase(row.peer, peer or "*")
    ]
    if not found:
        raise LookupError(f"printed.toml: no benchmark is called {pattern!r}")
    return found


def _filled(template: str, figures: dict[str, Figure]) -> str:
    return re.sub(r"\{(\w+)\}", lambda match: str(figures[match[1]]), template)


def _rounded(value: float) -> str:
    """Two digits; a value just above 1 with three decimals."""
    if 1.0 <= value < 1.1:
        return f"{value:.3f}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(value)))}f}" if value > 0.0 else "0"
