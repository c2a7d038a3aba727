"""The docs' table of speed is the one that the benchmarks print, and --check finds a boast."""

import importlib
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def benchmarks(monkeypatch):
    """The modules `printed` and `frame` of the benchmarks."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "python" / "benchmarks"), *sys.path])
    yield importlib.import_module("printed"), importlib.import_module("frame")
    for name in ("printed", "frame"):
        sys.modules.pop(name)


def measured(printed, frame, ratio, error):
    """A row for every pattern of the table."""
    rows = []
    for line in printed._LINES:
        for pattern in line["of"]:
            name, _, peer = pattern.partition("@")
            answer = (name.replace("*", "x"), peer or "peer", error, 1.0, True)
            rows.append(frame.Row(*answer, ratio=ratio))
    return rows


def test_a_printed_table_holds_until_a_figure_is_over_15_percent_better_than_measured(benchmarks):
    printed, frame = benchmarks
    page = f"text\n\n{printed.table(measured(printed, frame, 10.0, 0.5))}<!-- end -->\n"
    assert printed.too_good(page, measured(printed, frame, 8.8, 0.57)) == []
    slower = printed.too_good(page, measured(printed, frame, 8.6, 0.5))
    assert len(slower) == sum(len(line["of"]) for line in printed._LINES)
    assert "10 is printed, 8.6 measured" in slower[0]
    worse = printed.too_good(page, measured(printed, frame, 10.0, 0.6))
    assert len(worse) == sum("{error}" in line["problem"] for line in printed._LINES)
    cut = printed.too_good(re.sub(r"\| slerp.*\n", "", page), measured(printed, frame, 10.0, 0.5))
    assert "rows are printed" in cut[0]


def test_the_page_on_speed_has_the_rows_of_the_table(benchmarks):
    printed, frame = benchmarks
    faults = printed.too_good(
        (ROOT / "docs" / "speed.md").read_text(), measured(printed, frame, 1e6, 0.0)
    )
    assert faults == []
