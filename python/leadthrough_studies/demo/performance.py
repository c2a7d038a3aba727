"""The demo as a whole: its scenes one after the other, with their files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path

from rich.progress import Progress

from leadthrough import check
from leadthrough.errors import MissingDependency
from leadthrough.io import lasa
from leadthrough_studies.demo import report, scenes
from leadthrough_studies.demo.performed import Performed
from leadthrough_studies.handwriting.demo import Handwriting

# Names of columns, and rows.
Table = tuple[Sequence[str], Sequence[Sequence[str]]]


@dataclass(frozen=True, eq=False)
class Performance:
    """The scenes that were performed.

    Attributes:
        tables: of the measures, each the names of its columns and its rows.
        remarks: sentences on the files and on what is missing.
        ok: whether every motion keeps all limits and every arm is clear.
    """

    tables: list[Table]
    remarks: list[str]
    ok: bool


def perform(names: Sequence[str], motions: Sequence[str], out: Path) -> Performance:
    """Perform scenes and write their files, with bars of progress.

    Args:
        names: of the scenes; none for all, without the handwriting if its set is not installed.
        motions: of the handwriting set; none for eight of them.
        out: folder of the files, made if missing.

    Raises:
        InvalidInput: if the set has no such motion; before any scene is performed.
        MissingDependency: if the handwriting or a motion is named and the set is not installed.
    """
    for motion in motions:
        check.choice(motion, "motion", lasa.motions())
    out.mkdir(parents=True, exist_ok=True)  # before the scenes, which take their time
    wanted = list(dict.fromkeys(names or scenes.NAMES))
    left_out = "" if names or motions else _missing()
    if left_out:
        wanted.remove(scenes.HANDWRITING)
    others = [name for name in wanted if name != scenes.HANDWRITING]
    written: list[Handwriting] = []
    if scenes.HANDWRITING in wanted:
        # The other scenes on another core meanwhile.
        with ProcessPoolExecutor(1, get_context("spawn")) as second:
            promised = second.map(scenes.other, others, repeat(out))
            with Progress() as progress:  # ended with the loop, also by an error
                tracked = progress.track(motions or scenes.MOTIONS, description="Writing")
                first, written = scenes.handwriting(tracked, out)
            performed = [first, *_tracked(promised, others)]
    else:
        performed = _tracked((scenes.other(name, out) for name in others), others)
    report.write_page(performed, written, out)
    simulated = report.write_simulation(performed[0], out)
    remarks = [
        f"Figures, tables and the joint trajectories: {out}/",
        f"Page to open in a browser: {out / 'report.html'}",
        f"{performed[0].name} under gravity and a controller: {simulated}",
        *([f"Without handwriting: {left_out}"] if left_out else []),
    ]
    tables: list[Table] = [report.glance(performed), *([report.errors(written)] if written else [])]
    ok = all(each.ok for each in performed) and all(each.ok for each in written)
    return Performance(tables, remarks, ok)


def _tracked(found: Iterable[Performed], names: Sequence[str]) -> list[Performed]:
    with Progress(disable=not names) as progress:
        title = " and ".join(names).capitalize()
        return [*progress.track(found, total=len(names), description=title)]


def _missing() -> str:
    """Missing packages for the handwriting, as a message; empty if there are none."""
    try:
        lasa.motions()
    except MissingDependency as error:
        return str(error)
    return ""
