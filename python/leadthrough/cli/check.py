"""`leadthrough check`: a motion in, a verdict out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import chain, options

if TYPE_CHECKING:
    from leadthrough.arm import Clearance
    from leadthrough.simulation import SimulationReport
    from leadthrough.timing import Peak


def check(
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    obstacle: options.Obstacles = None,
    margin: options.Margin = 0.005,
    physics: Annotated[
        bool,
        typer.Option(
            "--physics", help="Also simulate it under gravity; `leadthrough simulate` tells more."
        ),
    ] = False,
    as_json: options.AsJson = False,
) -> None:
    """Check a joint motion against the arm's limits and for collisions, also with itself.

    Exits with code 1 if a limit is exceeded, there is a collision, or the simulated arm fails.

    leadthrough check timed.json --robot panda --obstacle box:0.1,0.1,0.4@0.5,0.2,0.2
    """
    from leadthrough.cli import parse, tables
    from leadthrough.cli import robot as robots
    from leadthrough.shapes import Scene
    from leadthrough.timing import check_limits

    arm = robots.load(robot, limits, base, tip, mesh_folder)
    joints = robots.joints_in(arm, motion)
    scene = Scene([parse.obstacle(text) for text in obstacle or ()], margin)
    kept = check_limits(joints, arm.limits)
    with tables.busy("checking"):
        clearance = arm.check(joints, scene)
    simulated = None
    if physics:
        from leadthrough.simulation import simulate

        with tables.busy("simulating"):
            simulated = simulate(arm, joints, scene)
    quantities = ("position", "velocity", "acceleration", "jerk")
    found = {
        "ok": kept.ok and clearance.ok and (simulated is None or simulated.ok),
        "limits_kept": kept.ok,
        **{f"{name}_used": _peak(getattr(kept, name), as_json) for name in quantities},
        "clear": clearance.ok,
        "nearest_obstacle": _approach(clearance.obstacles, as_json),
        "nearest_itself": _approach(clearance.itself, as_json),
        "duration": joints.duration,
    }
    if simulated is not None:
        found["simulated"] = _simulated(simulated, as_json)
    tables.facts(found, as_json=as_json, units={"duration": "s"})
    if not as_json:
        fails = simulated is not None and not simulated.ok
        _hint(ctx, motion, limits_kept=kept.ok, clear=clearance.ok, fails=fails)
    if not found["ok"]:
        raise typer.Exit(1)


def _hint(ctx: typer.Context, motion: Path, *, limits_kept: bool, clear: bool, fails: bool) -> None:
    arm = chain.arm(ctx)
    if not clear:
        chain.advise("replan with a larger --margin or another --posture, then retime and check")
    elif not limits_kept:
        chain.hint(
            ctx,
            "leadthrough",
            "retime",
            motion,
            *arm,
            "-o",
            motion.with_stem(f"{motion.stem}-timed"),
        )
    elif fails:
        chain.hint(ctx, "leadthrough", "simulate", motion, *arm, *chain.typed(ctx, "obstacle"))
    else:
        page = motion.with_suffix(".html")
        chain.hint(
            ctx, "leadthrough", "view", motion, *arm, *chain.typed(ctx, "obstacle"), "--html", page
        )


def _simulated(report: SimulationReport, as_json: bool) -> object:
    from leadthrough.cli import simulated

    return simulated.facts(report, as_json=True) if as_json else str(report)


def _peak(peak: Peak | None, as_json: bool) -> object:
    if as_json:
        return peak and {"ratio": peak.ratio, "joint": peak.joint, "time": peak.time}
    return "not checked, the limit is not known" if peak is None else str(peak)


def _approach(clearance: Clearance, as_json: bool) -> object:
    nearest = clearance.closest
    if as_json:
        return nearest and {
            "distance": nearest.distance,
            "bodies": nearest.bodies,
            "time": nearest.time,
        }
    return "nothing to collide with" if nearest is None else str(nearest)
