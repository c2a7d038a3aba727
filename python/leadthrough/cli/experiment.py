"""`leadthrough experiment`: studies from the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from leadthrough.cli import completion, options
from leadthrough.cli.tables import table


def experiment(
    name: Annotated[
        str | None,
        typer.Argument(
            help="Name of the study; leave it out to list all studies.",
            autocompletion=completion.one_of(*completion.STUDIES),
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Run a small part of the study.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; by default leadthrough-NAME.")
    ] = None,
    seed: options.Seed = 0,
    jobs: Annotated[
        int, typer.Option(help="Number of parallel processes; the same as --on local:N.")
    ] = 1,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
) -> None:
    """Run a study; results that are already in its folder are not computed again.

    leadthrough experiment lasa --quick --on tcp://host:8786
    """
    from leadthrough import check
    from leadthrough.cli import errors
    from leadthrough_studies import study
    from leadthrough_studies.catalogue import STUDIES

    if name is None:
        print("\n".join(STUDIES))
        return
    chosen = STUDIES[check.choice(name, "NAME", STUDIES)]
    folder = out or Path(f"leadthrough-{name}")
    config = chosen.configure(quick, check.integer(seed, "seed", at_least=0))
    place = on or f"local:{check.integer(jobs, 'jobs', at_least=1)}"
    with errors.going_on():
        outcome = study.run(chosen, config, out=folder, on=place, task_timeout=task_timeout)
    console = Console()
    if outcome.report.table:
        console.print(table(outcome.report.table))
    print(f"results.json, table.csv and figures: {folder}/")
    for page in outcome.report.pages:
        print(f"Page to open in a browser: {folder / page}.html")
    if simulated := outcome.report.summary.get("simulated"):
        print(f"Under gravity and a controller: {simulated}")
    for failure in outcome.failures:
        told = f"failed: {failure['task']}: {failure['error']}: {failure['message']}"
        console.print(told, style="red", markup=False)
    if outcome.failures:
        raise typer.Exit(1)
