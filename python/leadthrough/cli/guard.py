"""`leadthrough guard`: a motion in, what may run of it out."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from leadthrough.cli import chain, options


def guard(
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    out: options.Output,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    obstacle: options.Obstacles = None,
    margin: options.Margin = 0.005,
    rate: Annotated[
        float | None,
        typer.Option(help="Commands per second; by default those of the motion."),
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            help="Joint positions, such as 0,-0.5,1, at which the arm rests; by default those of "
            "the first sample."
        ),
    ] = None,
    format: options.FormatName = None,
    as_json: options.AsJson = False,
) -> None:
    """Write what may run of a joint motion: as it is, or the nearest motion that is allowed.

    Jumps are bridged, the motion is slowed down along its path where it exceeds a limit, and it is
    cut before a contact. The motion written ends at rest. Exits with code 1 if none of it may run;
    where not even standing still is allowed, nothing is written.

    leadthrough guard motion.json --robot panda --obstacle box:0.1,0.1,0.4@0.5,0.2,0.2 -o safe.json
    """
    import numpy as np

    from leadthrough.cli import errors, parse, reading, tables
    from leadthrough.cli import robot as robots
    from leadthrough.guard import Guard
    from leadthrough.guard.admission import from_state
    from leadthrough.io import write_motion
    from leadthrough.shapes import Scene

    reading.check_output(out, format)
    arm = robots.load(robot, limits, base, tip, mesh_folder)
    joints = robots.joints_in(arm, motion)
    scene = Scene([parse.obstacle(text) for text in obstacle or ()], margin)
    shown = 1.0 / float(np.diff(joints.times).min(initial=1.0))
    per_second = shown if rate is None else rate
    admits = Guard(arm, scene, rate=per_second)
    if start is not None:
        here, chunk = parse.numbers(start, "--start"), joints
    else:
        here, chunk = joints.positions[0], joints[1:] if len(joints) > 1 else joints
    with errors.naming(state="--start"):
        answer = admits.admit(chunk, here)
    rest = answer.to_rest
    now = chunk.times[0] - 1.0 / per_second
    events = [replace(each, time=each.time - now) for each in rest.events]
    written = from_state(
        here,
        np.concatenate([here[None], rest.positions]),
        names=arm.joint_names,
        period=1.0 / per_second,
        events=tuple(events),
    )
    if answer.safe:
        with errors.naming(path="--out", trajectory=f"--out {out}", motion=f"--out {out}"):
            write_motion(written, out, format=format)
    found = {
        "motion": str(out) if answer.safe else "not written",
        "verdict": answer.verdict,
        "safe": answer.safe,
        "reasons": [str(each) for each in answer.reasons],
        "duration_before": joints.duration,
        "duration": written.duration,
        "rate": per_second,
    }
    units = {"duration_before": "s", "duration": "s", "rate": "Hz"}
    tables.facts(found, as_json=as_json, units=units)
    if answer.safe and not as_json and reading.can_read(out):
        chain.hint(ctx, "leadthrough", "check", out, *chain.arm(ctx), *chain.typed(ctx, "obstacle"))
    if answer.verdict == "braking" or not answer.safe:
        raise typer.Exit(1)
