"""`leadthrough check`: a motion in, a verdict out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import chain, options

if TYPE_CHECKING:
    from leadthrough.arm import Clearance
    from leadthrough.timing import Peak


def check(
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    obstacle: options.Obstacles = None,
    margin: Annotated[float, typer.Option(help="Clearance to keep from obstacles, in m.")] = 0.0,
    as_json: options.AsJson = False,
) -> None:
    """Check a joint motion against the arm's limits and for collisions, also with itself.

    Exits with code 1 if a limit is exceeded or there is a collision.

    leadthrough check timed.json --robot panda --obstacle box:0.1,0.1,0.4@0.5,0.2,0.2
    """
    from leadthrough.cli import parse, tables
    from leadthrough.cli import robot as robots
    from leadthrough.timing import check_limits

    arm = robots.load(robot, limits, base, tip)
    joints = robots.joints_in(arm, motion)
    obstacles = [parse.obstacle(text) for text in obstacle or ()]
    kept = check_limits(joints, arm.limits)
    with tables.busy("checking"):
        clearance = arm.check(joints, obstacles, margin=margin)
    quantities = ("position", "velocity", "acceleration", "jerk")
    found = {
        "ok": kept.ok and clearance.ok,
        "limits_kept": kept.ok,
        **{f"{name}_used": _peak(getattr(kept, name), as_json) for name in quantities},
        "clear": clearance.ok,
        "nearest_obstacle": _approach(clearance.obstacles, as_json),
        "nearest_itself": _approach(clearance.itself, as_json),
        "duration": joints.duration,
    }
    tables.facts(found, as_json=as_json, units={"duration": "s"})
    if not as_json:
        _hint(ctx, motion, limits_kept=kept.ok, clear=clearance.ok)
    if not found["ok"]:
        raise typer.Exit(1)


def _hint(ctx: typer.Context, motion: Path, *, limits_kept: bool, clear: bool) -> None:
    arm = chain.arm(ctx)
    if not clear:
        chain.advise("plan with a larger --obstacle or another --posture, then retime and check")
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
    else:
        page = motion.with_suffix(".html")
        chain.hint(
            ctx, "leadthrough", "view", motion, *arm, *chain.typed(ctx, "obstacle"), "--html", page
        )


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
