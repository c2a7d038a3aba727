"""Recordings with faults in, motions to learn from out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadthrough.cli import options


def clean(
    file: Annotated[Path, typer.Argument(help="Recordings; `leadthrough info` tells them.")],
    out: options.Output,
    column: options.Columns = None,
    rate: options.Rate = None,
    angles: options.Angles = None,
    quaternions: options.Quaternions = None,
    topic: options.Topic = None,
    longest_gap: Annotated[
        float, typer.Option(help="s without a sample that are let pass; more is an error.")
    ] = 0.5,
    longest_pause: Annotated[
        float | None, typer.Option(help="s that are left of a pause; by default all.")
    ] = None,
    new_rate: Annotated[float | None, typer.Option(help="Hz to sample anew at.")] = None,
    smoothing: Annotated[
        float | None, typer.Option(help="s, a window; joints get their velocities with it.")
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Leave out a recording's faults and say what they were.

    Of several recordings in a file each goes to a file of its own, with its number.

    leadthrough clean day.csv --longest-pause 0.3 --smoothing 0.2 -o clean.csv
    """
    import json

    from leadthrough import io, preprocess
    from leadthrough.cli import parse

    recordings = io.read_recordings(
        file,
        columns=parse.columns(column or []),
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
    )
    cleaned = [
        preprocess.clean(
            each,
            longest_gap=longest_gap,
            longest_pause=longest_pause,
            rate=new_rate,
            smoothing=smoothing,
        )
        for each in recordings
    ]
    several = len(cleaned) > 1
    found = []
    for number, (shown, report) in enumerate(cleaned, start=1):
        path = out.with_name(f"{out.stem}_{number}{out.suffix}") if several else out
        io.write_motion(shown.motion, path)
        found.append({"recording": shown.name, "file": str(path), "report": report.as_dict()})
        if not as_json:
            print(f"{shown.name}: {path}\n{report}")
    if as_json:
        print(json.dumps(found, allow_nan=False))
