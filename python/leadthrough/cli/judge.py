"""`leadthrough judge`: what each recording is worth, its faults, and what to show next."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from leadthrough.cli import completion, options

if TYPE_CHECKING:
    from leadthrough.judging import Judgement


def judge(
    files: options.Recordings,
    model: Annotated[
        str | None,
        typer.Option(
            help="Model that is learned with one recording left out after the other, as of "
            "`leadthrough learn`; by default promp.",
            autocompletion=completion.models,
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option("--set", help="Parameter of the model, such as weights=80; may be repeated."),
    ] = None,
    goals: Annotated[
        str | None,
        typer.Option(
            help="Region in which the next demonstration may end, to suggest where: distances "
            "DX,DY,DZ to both sides of the recordings' mean goal, or two corners X,Y,Z:X,Y,Z.",
        ),
    ] = None,
    rest: options.Rest = 0.0,
    speed: options.Speed = None,
    angular_speed: options.AngularSpeed = None,
    column: options.Columns = None,
    rate: options.Rate = None,
    angles: options.Angles = None,
    quaternions: options.Quaternions = None,
    topic: options.Topic = None,
    seed: options.Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder that keeps what is computed, to go on there.")
    ] = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Tell which recordings of a motion are faulty or unlike the others, and what each is worth.

    leadthrough judge shown/*.csv --goals 0.1,0.1,0.05
    """
    import numpy as np

    from leadthrough.cli import errors, parse, reading, tables
    from leadthrough.cli.learn import model_of
    from leadthrough.io import read_demonstrations
    from leadthrough.judging import judge_demonstrations

    recordings = reading.listed(files)
    reading.refuse_skills(recordings)
    shown = read_demonstrations(
        recordings,
        columns=parse.columns(column or []),
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        rest=math.inf,
    )
    shown = reading.trimmed(shown, rest=rest, speed=speed, angular_speed=angular_speed)
    middle = np.mean([each.motion.positions[-1] for each in shown], axis=0)
    with tables.busy("judging"), errors.naming(demonstrations="RECORDINGS"):
        found = judge_demonstrations(
            shown,
            model=model_of(model or "promp", parse.parameters(parameter or [])),
            goals=None if goals is None else parse.places(goals, middle, "--goals"),
            seed=seed,
            on=on,
            out=out,
            task_timeout=task_timeout,
        )
    _print(found, as_json=as_json)


def _print(found: Judgement, *, as_json: bool) -> None:
    from leadthrough.cli import tables

    rows = [
        {
            "recording": each.name,
            "suspicion": each.suspicion,
            "faults": ", ".join(each.faults),
            "worth": each.worth,
            "leave_out": each.remove,
        }
        for each in found.verdicts
    ]
    told: dict[str, object] = {"recordings": rows} if as_json else {}
    told |= {"left_out_error": found.error, "without_those": found.error_without}
    if found.next is not None:
        told |= {"show_next": found.next.goal.tolist(), "uncertainty": found.next.uncertainty}
    if not as_json:
        Console().print(tables.table(rows))
    tables.facts(told, as_json=as_json)
