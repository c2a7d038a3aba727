"""`leadthrough demo`: the whole pipeline, from demonstrations to three arms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table

if TYPE_CHECKING:
    from leadthrough_studies.demo.performed import Performed
    from leadthrough_studies.handwriting.demo import Handwriting

SCENES = ("handwriting", "pouring", "harvesting")


def demo(
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("leadthrough-demo"),
    scene: Annotated[
        list[str] | None,
        typer.Option(
            help="Scene to show: handwriting, pouring or harvesting; may be repeated. By default "
            "all three."
        ),
    ] = None,
    motion: Annotated[
        list[str] | None,
        typer.Option(
            help="Motion of the LASA handwriting set, such as GShape; may be repeated. By default "
            "eight of them. The arm is shown with the first."
        ),
    ] = None,
) -> None:
    """Show three arms that learn: a UR3 writes, a Panda pours, a TIAGo harvests."""
    from leadthrough import check
    from leadthrough_studies.demo import report, scenes

    wanted = dict.fromkeys(check.choice(name, "--scene", SCENES) for name in scene or SCENES)
    left_out = "" if scene or motion else _missing()
    if left_out:
        del wanted["handwriting"]
    shown: list[Performed] = []
    written: list[Handwriting] = []
    if "handwriting" in wanted:
        names = track(motion or scenes.MOTIONS, description="Writing")
        first, written = scenes.handwriting(names, out)
        shown.append(first)
    others = [name for name in wanted if name != "handwriting"]
    told = track(others, description=" and ".join(others).capitalize(), disable=not others)
    shown += [scenes.other(name, out) for name in told]
    report.write_page(shown, written, out)
    simulated = report.write_simulation(shown[0], out)
    console = Console()
    console.print(_table(*report.glance(shown)))
    if written:
        console.print(_table(*report.errors(written)))
    # Plain: rich would take the extra's name in brackets for a style.
    print(f"Figures, tables and the joint trajectories: {out}/")
    print(f"Page to open in a browser: {out / 'report.html'}")
    print(f"{shown[0].name} under gravity and a controller: {simulated}")
    if left_out:
        print(f"Without handwriting: {left_out}")
    if not (all(each.ok for each in shown) and all(each.ok for each in written)):
        raise typer.Exit(1)


def _missing() -> str:
    """What to install for the handwriting; empty if it is there."""
    from leadthrough.errors import MissingDependency
    from leadthrough.io import lasa

    try:
        lasa.motions()
    except MissingDependency as error:
        return str(error)
    return ""


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(*columns, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for row in rows:
        table.add_row(*row)
    return table
