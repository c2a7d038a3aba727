"""Studies from the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from leadthrough.cli.tables import table


def experiment(
    name: Annotated[str | None, typer.Argument(help="A study; left out, lists them.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A small part of the study.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder for the results.")] = None,
    seed: Annotated[int, typer.Option(help="Of whatever is drawn at random.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes.")] = 1,
) -> None:
    """Run a study; what its folder already holds is not computed again."""
    from leadthrough import check
    from leadthrough_studies import study
    from leadthrough_studies.catalogue import STUDIES

    if name is None:
        print("\n".join(STUDIES))
        return
    chosen = STUDIES[check.choice(name, "NAME", STUDIES)]
    folder = out or Path(f"leadthrough-{name}")
    config = chosen.configure(quick, check.integer(seed, "seed", at_least=0))
    outcome = study.run(chosen, config, out=folder, jobs=jobs)
    console = Console()
    console.print(table(outcome.report.table))
    console.print(f"results.json, table.csv and figures: {folder}/")
    for failure in outcome.failures:
        console.print(f"failed: {failure}", style="red", markup=False)
    if outcome.failures:
        raise typer.Exit(1)
