"""Figures printed in the documentation are those of the results in docs/results.

A figure is followed by a comment with its place: the file, the column, and what its row has in
other columns, as in `20<!-- singularity/draws below_8_paper table=I; unit_m_per_rad=1.0 -->`.
"""

import csv
import re
from decimal import Decimal
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "studies.md").read_text(encoding="utf-8")
PRINTED = "".join(page.read_text(encoding="utf-8") for page in sorted(DOCS.rglob("*.md")))
FIGURE = re.compile(r"(-?[\d.]+(?:e-?\d+)?)<!-- (\S+) (\S+) (.*?) -->")
VERDICTS = {"holds", "fails", "cannot be told", "not yet run"}
SOURCES = ("Yang, Liu and Pears", "Grioli's notes", "Prados et al.", "Lauretti et al.")
CLAIMS = {
    source: [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in re.split(rf"^### Claims of {source}.*$", PAGE, flags=re.MULTILINE)[1]
        .split("\n#")[0]
        .splitlines()
        if line.startswith("| ")
    ][1:]
    for source in SOURCES
}


def stored(place, column, wanted):
    """The one entry of a column in the rows with the wanted entries."""
    with (DOCS / "results" / f"{place}.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for each in wanted.split("; "):
        name, value = each.split("=")
        rows = [row for row in rows if row[name] == value]
    assert len(rows) == 1, f"{place}: {len(rows)} rows with {wanted}"
    return Decimal(rows[0][column])


@pytest.mark.parametrize(("printed", "place", "column", "wanted"), FIGURE.findall(PRINTED))
def test_a_printed_figure_is_the_stored_one_rounded(printed, place, column, wanted):
    shown = Decimal(printed)
    half = Decimal(5).scaleb(int(shown.as_tuple().exponent) - 1)
    assert abs(shown - stored(place, column, wanted)) <= half


@pytest.mark.parametrize("source", SOURCES)
def test_every_claim_has_a_verdict_and_its_figures_a_source(source):
    assert len(CLAIMS[source]) >= 15
    for claim, where, run, verdict, figures in CLAIMS[source]:
        assert claim and where, claim
        assert verdict in VERDICTS, claim
        assert (run == "" and figures == "") or verdict != "not yet run", claim
        assert run or verdict == "not yet run", claim
        assert not re.search(r"(?<!joint )[0-9]", FIGURE.sub("", figures)), (
            f"without a source: {figures}"
        )


def test_every_stored_table_is_printed_from():
    used = {place for _, place, _, _ in FIGURE.findall(PRINTED)}
    files = (DOCS / "results").rglob("*.csv")
    assert used == {str(file.relative_to(DOCS / "results").with_suffix("")) for file in files}
