"""Command line: parse, call, print."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table

from leadthrough.errors import LeadthroughError

app = typer.Typer(no_args_is_help=True, add_completion=False)


@app.callback()
def leadthrough() -> None:
    """Hand-guided demonstrations in, executable robot-arm motion out."""


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("leadthrough-demo"),
    motion: Annotated[
        list[str] | None, typer.Option(help="A motion of the LASA set; may be repeated.")
    ] = None,
) -> None:
    """Learn human handwriting, plan it around a box and write it with a UR3."""
    from leadthrough.arm import Arm
    from leadthrough.experiments import handwriting, handwriting_report

    config = handwriting.HandwritingConfig()
    arm = Arm.load(config.robot)
    results = []
    for name in track(motion or handwriting.MOTIONS, description="Learning and writing"):
        result = handwriting.run(name, arm, config)
        handwriting_report.write_motion(result, arm.limits, out / name)
        results.append(result)
    handwriting_report.write_summary(results, out)

    columns = ("motion", "SEA", "V_rmse", "DTWD/N", "Fréchet", "time s", "slowed", "limits", "arm")
    table = Table(*columns)
    rows = handwriting_report.error_rows(results)
    for row, result in zip(rows, results, strict=False):
        verdict = "kept" if result.limits.ok else "exceeded"
        slowed = f"x {result.slowing:.2f}"
        whole_arm = "clear" if result.clearance.ok else "hits"
        table.add_row(*row, f"{result.joints.duration:.2f}", slowed, verdict, whole_arm)
    table.add_row(*rows[-1], end_section=True)
    console = Console()
    console.print(table)
    console.print(f"Figures, errors.csv and the joint trajectories: {out}/")
    if not all(result.limits.ok and result.clearance.ok for result in results):
        raise typer.Exit(1)


@app.command()
def experiment(
    name: Annotated[str, typer.Argument(help="lasa, singularity, trajectories or ur3")],
    quick: Annotated[bool, typer.Option("--quick", help="A small part of the study.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder for the results.")] = None,
    seed: Annotated[int, typer.Option(help="Of whatever is drawn at random.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes.")] = 1,
) -> None:
    """Run a study; what its folder already holds is not computed again."""
    from leadthrough import check
    from leadthrough.experiments import study
    from leadthrough.experiments.catalogue import STUDIES

    chosen = STUDIES[check.choice(name, "NAME", STUDIES)]
    folder = out or Path(f"leadthrough-{name}")
    config = chosen.configure(quick, check.integer(seed, "seed", at_least=0))
    outcome = study.run(chosen, config, out=folder, jobs=jobs)
    console = Console()
    console.print(_table(outcome.report.table))
    console.print(f"results.json, table.csv and figures: {folder}/")
    for failure in outcome.failures:
        console.print(f"failed: {failure}", style="red", markup=False)
    if outcome.failures:
        raise typer.Exit(1)


def _table(rows: list[dict[str, Any]]) -> Table:
    """The rows; as columns where that is narrower."""
    # Words break where there is no room for a column; names with underscores do not.
    names = [name.replace("_", " ") for name in rows[0]] if rows else []
    lines = [names, *(list(row.values()) for row in rows)]
    if len(names) > len(lines):
        lines = [list(line) for line in zip(*lines, strict=True)]
    table = Table(box=box.SIMPLE, padding=0, show_header=False)
    for line in lines:
        table.add_row(*map(_cell, line))
    return table


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return "" if value is None else str(value)


def main() -> None:
    """Entry point: an expected error is one line on stderr and exit code 2."""
    try:
        app()
    except (LeadthroughError, OSError) as error:
        print(f"leadthrough: {error}", file=sys.stderr)
        sys.exit(2)
