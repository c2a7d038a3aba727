"""`leadthrough demo`: the whole pipeline, from handwriting to a robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table


def demo(
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("leadthrough-demo"),
    motion: Annotated[
        list[str] | None,
        typer.Option(
            help="Motion of the LASA handwriting set, such as GShape; may be repeated. By default "
            "eight of them."
        ),
    ] = None,
) -> None:
    """Learn human handwriting, plan it around a box and write it with a UR3 arm."""
    from leadthrough.arm import Arm
    from leadthrough_studies.handwriting import report
    from leadthrough_studies.handwriting.demo import MOTIONS, HandwritingConfig, run

    config = HandwritingConfig()
    arm = Arm.load(config.robot)
    results, learning = [], []
    for name in track(motion or MOTIONS, description="Learning and writing"):
        result = run(name, arm, config)
        learning.append(report.write_motion(result, arm.limits, out / name))
        results.append(result)
    overview = report.write_summary(results, out)
    report.write_page(results, arm, config, out, overview=overview, learning=learning)

    simulated = report.write_simulation(results[0], arm, config, out)

    columns = ("motion", "SEA\nmm²", "V_rmse\nmm/s", "DTWD/N\nmm", "Fréchet\nmm", "time\ns")
    table = Table(*columns, "slowed", "limits", "arm", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    rows = report.error_rows(results)
    for row, result in zip(rows, results, strict=False):
        verdict = "kept" if result.limits.ok else "exceeded"
        slowed = f"x {result.slowing:.2f}"
        whole_arm = "clear" if result.clearance.ok else "hits"
        table.add_row(*row, f"{result.joints.duration:.2f}", slowed, verdict, whole_arm)
    table.add_row(*rows[-1], end_section=True)
    console = Console()
    console.print(table)
    console.print(f"Figures, errors.csv and the joint trajectories: {out}/")
    console.print(f"Report to open in a browser: {out / 'report.html'}")
    console.print(f"The first motion under gravity and a controller: {simulated}")
    if not all(result.limits.ok and result.clearance.ok for result in results):
        raise typer.Exit(1)
