"""`leadthrough start`: an arm and recordings in, a first checked motion out, by other commands."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

import leadthrough as lt
from leadthrough.cli import options, output
from leadthrough.cli.command import PROFILE, read_profile

if TYPE_CHECKING:
    from leadthrough.cli import questions

_SKILL, _MOTION, _TIMED, _PAGE = "skill.npz", "motion.json", "timed.json", "motion.html"
_RATE = "500"  # Hz, which most controllers take


def start(
    *,
    ctx: typer.Context,
    arm: options.ArmArgument,
    files: options.Recordings,
    details: options.ArmDetails,
    layout: options.ReadOptions,
    yes: bool = False,
) -> None:
    """Make a first checked motion from a robot's URDF and recordings, and a page that shows it.

    Asks for what the files leave open, writes leadthrough.toml, and runs the commands it prints.

    leadthrough start arm.urdf recorded

    Options:
        arm: URDF of the robot, or a robot's name, as for --robot.
        yes: Take all proposals instead of asking.
    """
    from leadthrough.cli import questions, reading, robot as robots

    ask = questions.taken if yes else questions.asked
    recordings = reading.listed(files)
    reading.refuse_skills(recordings)
    table = reading.first_table(recordings[0], layout.request())
    stated = read_profile()
    if stated.get("robot") == arm:
        robots.refuse(f"a robot that {PROFILE} does not describe", **vars(details))
    else:
        stated = write_profile(ctx, ask, arm, _with_ends(ask, arm, details, table.names))
    loaded = robots.load(arm, _details(stated))
    with reading.blaming(recordings[0]):
        layout = questions.settled(ask, loaded, table, layout)
    how = output.words(**vars(layout))
    clean = ["--clean"] if questions.are_faulty(recordings, layout, loaded) else []
    _run(ctx, "learn", *files, *how, *clean, "-o", _SKILL)
    _run(ctx, "plan", _SKILL, "-o", _MOTION)
    timing = ("retime", _MOTION, "--rate", _RATE, "-o", _TIMED)
    if not _knows_torques(loaded) or _run(ctx, *timing, "--torques", allowed=1):
        _run(ctx, *timing)
    verdict = _run(ctx, "check", _TIMED, allowed=1)
    shown = [word for file in files for word in ("--demonstrations", file)]
    _run(ctx, "view", _TIMED, *shown, *how, *clean, "--html", _PAGE)
    output.hint(ctx, "plan", _SKILL, "--move-goal=0.02,0,0.02", "-o", "moved.json")
    raise typer.Exit(verdict)


def _with_ends(
    ask: questions.Ask, arm: str, details: options.ArmDetails, names: Sequence[str]
) -> options.ArmDetails:
    """The details with the arm's base and tip, proposed around the joints that were recorded."""
    from leadthrough.arm import robot_files
    from leadthrough.cli import robot as robots
    from leadthrough.io.headers import joint

    with output.naming(path_or_xml="ARM", name="ARM"):
        document = robot_files.read(robots.urdf_of(arm))
    base, tip = robot_files.proposed_ends(document, [joint(name) for name in names])
    return replace(
        details,
        base=details.base or ask("first link of the arm (--base)", base),
        tip=details.tip or ask("last link of the arm, without fingers (--tip)", tip),
    )


def _knows_torques(arm: lt.Arm) -> bool:
    """Whether the arm has masses, and a limit of each joint's torque."""
    effort = arm.limits.effort
    known = effort is not None and ((effort > 0.0) & (effort < math.inf)).all()
    return bool(known) and arm._chain.mass > 0.0


def _details(stated: dict[str, str]) -> options.ArmDetails:
    paths = {key: Path(stated[key]) for key in ("limits", "mesh_folder") if key in stated}
    return options.ArmDetails(base=stated.get("base"), tip=stated.get("tip"), **paths)


def write_profile(
    ctx: typer.Context, ask: questions.Ask, arm: str, details: options.ArmDetails
) -> dict[str, str]:
    """Writes leadthrough.toml, and a limits file where limits are not known; the profile."""
    from leadthrough.cli import robot as robots

    if Path(PROFILE).exists():
        raise lt.errors.InvalidInput(
            f"{PROFILE}: is there already, for another robot; start in another folder"
        )
    known = robots.load(arm, details).limits
    limits = details.limits
    if known.acceleration is None or known.jerk is None or not known.velocity.all():
        urdf = robots.urdf_of(arm)
        limits = Path(ask("limits file, written with assumed values", f"{urdf.stem}-limits.toml"))
        if not limits.exists():
            words = output.words(base=details.base, tip=details.tip, limits=details.limits)
            _run(ctx, "info", urdf, *words, "--write-limits", limits)
    stated = {"robot": arm, **{key: str(each) for key, each in vars(details).items() if each}}
    if limits is not None:
        stated["limits"] = str(limits)
    lines = [f"{key} = {json.dumps(text, ensure_ascii=False)}\n" for key, text in stated.items()]
    Path(PROFILE).write_text("".join(lines), encoding="utf-8")
    print(f"wrote {PROFILE}")
    return stated


def _run(ctx: typer.Context, *words: str | Path, allowed: int = 0) -> int:
    """Prints and runs a command; ends with its exit code, unless that is 0 or allowed."""
    print(f"\n$ {output.line(ctx, *words)}", flush=True)
    root = ctx.find_root()
    debug = ["--debug"] if root.params.get("debug") else []
    arguments = [*debug, *map(str, words)]
    code = root.command.main(arguments, "leadthrough", standalone_mode=False, obj=output.GUIDED)
    if code not in (None, 0, allowed):
        raise typer.Exit(code)
    return code or 0
