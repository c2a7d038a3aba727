"""`leadthrough retime`: a motion in, the fastest one along its path out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import chain, options

if TYPE_CHECKING:
    from leadthrough.timing import Binding

_NO_LIMIT = "no limit"
_ROUNDED = 1e-2  # rad (m), the tolerance of a path that is free of a hand's tremor


def retime(
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    out: options.Output,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    rate: Annotated[float, typer.Option(help="Sampling rate of the result, in Hz.")] = 1000.0,
    path_tolerance: Annotated[
        float,
        typer.Option(help="Largest distance of the smoothed path from the samples, in rad (m)."),
    ] = 1e-5,
    keep_timing: Annotated[
        bool,
        typer.Option("--keep-timing", help="Reach no point of the path earlier than it does now."),
    ] = False,
    tip_speed: Annotated[float | None, typer.Option(help="Speed limit of the tip, in m/s.")] = None,
    torques: Annotated[
        bool, typer.Option("--torques", help="Also keep within the joint torque limits.")
    ] = False,
    start: Annotated[
        str | None,
        typer.Option(
            help="Joint positions, such as 0,-0.5,1, at which the arm rests before; a way from "
            "there onto the motion is written with it."
        ),
    ] = None,
    obstacle: options.Obstacles = None,
    format: options.FormatName = None,
    as_json: options.AsJson = False,
) -> None:
    """Run a joint motion as fast as velocity, acceleration and jerk limits allow.

    leadthrough retime motion.json --robot panda -o timed.json

    With --start, whole turns are taken the short way, and --obstacle names what the way has to
    keep clear of.

    leadthrough retime motion.csv --robot ur5.urdf --limits ur5.toml --rate 500 -o timed.script
    """
    from leadthrough import timing
    from leadthrough.cli import errors, parse, reading, tables
    from leadthrough.cli import robot as robots
    from leadthrough.guard import connect
    from leadthrough.io import write_motion

    reading.check_output(out, format)
    if start is None:
        robots.refuse("--start", obstacle=obstacle)
    around = [parse.obstacle(text) for text in obstacle or ()]
    arm = robots.load(robot, limits, base, tip, mesh_folder)
    path = robots.joints_in(arm, motion)
    with tables.busy("timing"):
        timed = timing.retime(
            path,
            arm.limits,
            rate=rate,
            path_tolerance=path_tolerance,
            not_before=path.times if keep_timing else None,
            tip_speed=tip_speed,
            jacobian=None if tip_speed is None else arm.jacobian,
            inverse_dynamics=arm.inverse_dynamics if torques else None,
        )
    limited = _limited_by(timing.binding_limits(timed, arm.limits))
    if start is not None:
        with errors.naming(state="--start"):
            timed = connect(parse.numbers(start, "--start"), timed, arm, around)
    with errors.naming(path="--out", trajectory=f"--out {out}", motion=f"--out {out}"):
        write_motion(timed, out, format=format)
    found = {
        "motion": str(out),
        "duration_before": path.duration,
        "duration": timed.duration,
        "samples": len(timed.times),
        "rate": rate,
        "limited_by": _fractions(limited),
    }
    units = {"duration_before": "s", "duration": "s", "rate": "Hz"}
    tables.facts(found, as_json=as_json, units=units)
    unbound, total = limited.get(_NO_LIMIT, 0.0), sum(limited.values())
    if path_tolerance < _ROUNDED and unbound > 0.5 * total:
        tables.note(
            f"for {unbound / total:.0%} of the time no limit binds: small bends of the path, "
            "such as tremor, hold the motion back; a larger --path-tolerance, up to 1e-2, rounds "
            "them"
        )
    if not as_json:
        if reading.can_read(out):
            chain.hint(ctx, "leadthrough", "check", out, *chain.arm(ctx))
        else:
            chain.advise(f"run {out} on the robot")


def _limited_by(bindings: Sequence[Binding]) -> dict[str, float]:
    """How long each limit binds, or none does, s."""
    lengths: dict[str, float] = {}
    for each in bindings:
        name = f"{each.joint} {each.kind}" if each.binds else _NO_LIMIT
        lengths[name] = lengths.get(name, 0.0) + each.end - each.start
    return lengths


def _fractions(limited: Mapping[str, float]) -> list[str]:
    """Which limits bind and for which fraction of the time, the longest first."""
    total = sum(limited.values())
    ranked = sorted(limited.items(), key=lambda item: -item[1])
    return [f"{name} {length / total:.0%}" for name, length in ranked if length > 0.005 * total]
