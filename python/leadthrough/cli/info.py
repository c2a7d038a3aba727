"""`leadthrough info`: what files contain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadthrough.cli import options


def info(
    files: Annotated[
        list[Path],
        typer.Argument(help="Recordings, motions, skills, ROS bags, data sets or URDFs."),
    ],
    column: options.Columns = None,
    rate: options.Rate = None,
    angles: options.Angles = None,
    quaternions: options.Quaternions = None,
    topic: options.Topic = None,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    as_json: options.AsJson = False,
) -> None:
    """Show what files contain, and report faults in recordings.

    leadthrough info day.csv --rate 50

    leadthrough info recorded.mcap skill.npz ur5.urdf
    """
    import json

    from leadthrough.cli import parse
    from leadthrough.io import request
    from leadthrough.show.info import describe

    asked = request.checked(
        columns=parse.columns(column or []),
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=None,
    )
    found = [describe(file, request=asked, limits=limits, base=base, tip=tip) for file in files]
    if as_json:
        print(json.dumps([each.as_dict() for each in found], allow_nan=False))
        return
    print("\n\n".join(map(str, found)))
