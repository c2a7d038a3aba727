"""`leadthrough clean`: recordings with faults in, motions to learn from out."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from leadthrough.cli import chain, episodes, options


def clean(
    ctx: typer.Context,
    files: options.Recordings,
    out: options.Output,
    column: options.Columns = None,
    rate: options.Rate = None,
    angles: options.Angles = None,
    quaternions: options.Quaternions = None,
    topic: options.Topic = None,
    longest_gap: Annotated[
        float,
        typer.Option(help="Longest time without samples to accept, in s; more is an error."),
    ] = 0.5,
    longest_pause: Annotated[
        float | None,
        typer.Option(help="Shorten longer pauses to this, in s; by default pauses are kept."),
    ] = None,
    pause: options.Pause = None,
    rest: options.Rest = 0.0,
    speed: options.Speed = None,
    angular_speed: options.AngularSpeed = None,
    new_rate: Annotated[float | None, typer.Option(help="Resample at this rate, in Hz.")] = None,
    smoothing: Annotated[
        float | None,
        typer.Option(help="Smoothing window, in s; also adds velocities to joint motions."),
    ] = None,
    table: episodes.FaultTable = None,
    as_json: options.AsJson = False,
) -> None:
    """Remove faulty samples from recordings and report what was removed.

    If there are several recordings, each is written to its own numbered file.

    leadthrough clean day.csv --longest-pause 0.3 --smoothing 0.2 -o clean.csv
    """
    import json
    from functools import partial

    from leadthrough import check, io, preprocess
    from leadthrough.cli import parse, reading

    reading.check_output(out)
    if new_rate is not None:
        check.number(new_rate, "--new-rate", above=0.0)
    how: dict[str, Any] = {
        "columns": parse.columns(column or []),
        "rate": rate,
        "angles": angles,
        "quaternions": quaternions,
        "topic": topic,
    }
    cleaned = partial(
        preprocess.clean,
        **({} if pause is None else {"pause": pause}),
        longest_gap=longest_gap,
        longest_pause=longest_pause,
        rest=rest,
        speed=speed,
        angular_speed=angular_speed,
        rate=new_rate,
        smoothing=smoothing,
    )
    if table is not None:
        episodes.check_table(table)
        stream = io.stream_recordings(reading.listed(files), **how)
        results = episodes.cleaned(stream, cleaned, table)
    else:
        recordings = io.read_recordings(reading.listed(files), **how)
        done = [cleaned(each) for each in recordings]
        results = ((number, *each) for number, each in enumerate(done, start=1))
    several = table is not None or len(done) > 1
    files_written = []
    found = []
    for number, shown, report in results:
        path = out.with_name(f"{out.stem}_{number}{out.suffix}") if several else out
        io.write_motion(shown.motion, path)
        files_written.append(path)
        if as_json:
            told = {"recording": shown.name, "file": str(path), "report": report.as_dict()}
            found.append(told)
        elif table is None:
            print(f"{shown.name}: {path}\n{report}")
    if as_json:
        print(json.dumps(found, allow_nan=False))
    elif table is not None:
        print(f"{len(files_written)} recordings cleaned; faults: {table}")
    else:
        chain.hint(ctx, "leadthrough", "learn", *files_written, "-o", "skill.npz")
