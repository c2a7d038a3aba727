"""How far a run is, and how long the rest will take, on a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from leadthrough.tasks.engine import Outcome

Shown = Callable[[Iterable[Outcome], int, str], Iterator[Outcome]]
"""What shows outcomes and passes them on: of the outcomes, their number and what they are."""


def shown(outcomes: Iterable[Outcome], total: int, what: str) -> Iterator[Outcome]:
    """The same outcomes, shown on stderr with an estimate of the time that is left.

    Args:
        outcomes: of a run.
        total: number of its tasks.
        what: what they are, such as "validating".
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    with Progress(*columns, TimeRemainingColumn(), console=console) as progress:
        bar = progress.add_task(what, total=total)
        known = failed = 0
        for each in outcomes:
            known, failed = known + each.known, failed + (each.failure is not None)
            # What was known before took no time, so that it says nothing of the rest.
            progress.update(bar, total=total - known, advance=0 if each.known else 1)
            progress.update(bar, description=_told(what, known, failed))
            yield each


def _told(what: str, known: int, failed: int) -> str:
    parts = [f"{known} known"] * bool(known) + [f"{failed} failed"] * bool(failed)
    return f"{what} ({', '.join(parts)})" if parts else what
