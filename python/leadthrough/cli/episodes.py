"""Data sets of many episodes: each cleaned as it comes, with its faults in a table."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import replacing

if TYPE_CHECKING:
    from leadthrough.io import Episode, Recording
    from leadthrough.motion import Demonstration
    from leadthrough.preprocess import CleaningReport

FaultTable = Annotated[
    Path | None,
    typer.Option(
        "--table",
        help="CSV file to write with the faults of each recording. What cannot be read or cleaned "
        "is then left out instead of ending the command, and data sets are read piece by piece.",
    ),
]
Cleaned = Callable[["Recording"], "tuple[Demonstration, CleaningReport]"]

_COLUMNS = (
    *("episode", "used", "samples", "left", "duration_s", "faults", "missing", "spikes"),
    *("unordered", "repeated", "flipped", "unnormalised", "longest_gap_s", "problem"),
)
_SUFFIX = ".csv"


def check_table(table: Path) -> None:
    """Refuses a table's name before anything is read."""
    if table.suffix.lower() != _SUFFIX:
        raise InvalidInput(f"--table: expected a name that ends in {_SUFFIX}, got {table}")


def cleaned(
    episodes: Iterable[Episode], clean: Cleaned, table: Path
) -> Iterator[tuple[int, Demonstration, CleaningReport]]:
    """The episodes that can be cleaned, one after the other, with their numbers, counted from 1."""
    used, problem = 0, "--table: there are no episodes"
    with replacing(table) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, _COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        for number, episode in enumerate(episodes, start=1):
            found = None
            problem = episode.problem
            if episode.recording is not None:
                try:
                    found = clean(episode.recording)
                except InvalidInput as error:
                    problem = f"{episode.name}: {error}"
            writer.writerow(_row(episode.name, found, problem))
            if found is not None:
                used += 1
                yield number, *found
    if not used:
        raise InvalidInput(problem)


def _row(
    name: str, found: tuple[Demonstration, CleaningReport] | None, problem: str
) -> dict[str, object]:
    if found is None:
        return {"episode": name, "used": "no", "problem": problem}
    shown, report = found
    return {
        "episode": name,
        "used": "yes",
        "samples": report.read,
        "left": report.left,
        "duration_s": round(shown.motion.duration, 6),
        "faults": report.faults,
        "missing": len(report.invalid),
        "spikes": len(report.spikes),
        "unordered": report.unordered,
        "repeated": report.repeated,
        "flipped": report.flipped,
        "unnormalised": report.unnormalised,
        "longest_gap_s": round(max((end - start for start, end in report.gaps), default=0.0), 6),
    }


def thinned(shown: Demonstration, samples: int) -> Demonstration:
    """The demonstration at no more than a number of evenly spaced times."""
    from leadthrough.preprocess import sample_evenly

    motion = shown.motion
    if len(motion) <= samples or motion.duration <= 0.0:
        return shown
    # A little more than needed, as the last sample comes no later than the old one.
    rate = (samples - 1) / motion.duration * (1.0 - 1e-12)
    return replace(shown, motion=sample_evenly(shown, rate=rate).motion)
