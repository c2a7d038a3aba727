"""`leadthrough view`: an arm and its motion, live in a browser or as an HTML file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from leadthrough.cli import completion, options


def view(
    motion: Annotated[
        Path | None,
        typer.Argument(
            help="Motion to show: of the joints, or poses that the tip follows.",
            autocompletion=completion.recordings,
        ),
    ] = None,
    robot: options.RobotName = "panda",
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    demonstrations: Annotated[
        list[Path] | None,
        typer.Option(
            help="Recording to draw, or a folder of them; may be repeated.",
            autocompletion=completion.recordings,
        ),
    ] = None,
    skill: Annotated[
        Path | None,
        typer.Option(
            help="Skill file; in the live page its goal and obstacles can be dragged.",
            autocompletion=completion.files(".npz"),
        ),
    ] = None,
    goal: Annotated[
        str | None,
        typer.Option(help="Goal of the skill: X,Y,Z in m, or a pose X,Y,Z/W,X,Y,Z."),
    ] = None,
    obstacle: options.Obstacles = None,
    column: options.Columns = None,
    rate: options.Rate = None,
    angles: options.Angles = None,
    quaternions: options.Quaternions = None,
    html: Annotated[
        Path | None,
        typer.Option(
            help="Write the page to this HTML file instead of opening a browser.",
            autocompletion=completion.files(".html"),
        ),
    ] = None,
    port: Annotated[int, typer.Option(help="Port of the live page; 0 picks a free one.")] = 0,
) -> None:
    """Show an arm and its motion, live in a browser or as an HTML file that needs no server.

    leadthrough view motion.csv --robot ur3 --html motion.html

    leadthrough view --robot panda --skill skill.npz --obstacle box:0.1,0.1,0.4@0.5,0,0.2
    """
    from leadthrough import check
    from leadthrough.cli import errors, parse, reading
    from leadthrough.cli import robot as robots
    from leadthrough.io import read_demonstrations
    from leadthrough.motion import JointTrajectory
    from leadthrough.show import viewing

    check.integer(port, "port", at_least=0, at_most=65535)
    arm = robots.load(robot, limits, base, tip, mesh_folder)
    asked = None if motion is None else reading.one_motion(motion, joints=robots.ranges(arm))
    if isinstance(asked, JointTrajectory):
        asked = robots.own_joints(arm, asked, str(motion))
    shown = []
    if not demonstrations:
        robots.refuse(
            "--demonstrations", column=column, rate=rate, angles=angles, quaternions=quaternions
        )
    else:
        named = parse.columns(column or [])
        files, known = reading.listed(demonstrations), robots.ranges(arm)
        shown = read_demonstrations(
            files,
            columns=named,
            rate=rate,
            angles=angles,
            quaternions=quaternions,
            joints=known,
            rest=math.inf,
        )
    with errors.naming(path="--html"):
        viewing.view(
            arm,
            asked,
            demonstrations=shown,
            skill=None if skill is None else reading.saved_skill(skill),
            goal=None if goal is None else parse.place(goal, "--goal"),
            scene=[parse.obstacle(text) for text in obstacle or ()],
            html=html,
            port=port,
        )
    if html is not None:
        print(f"wrote {html}: open it in a browser")
