"""Commands that show the package at work: `leadthrough view`, `demo` and `example`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.console import Console
from rich.table import Table

import leadthrough as lt
from leadthrough.cli import options, output
from leadthrough.cli.command import PROFILE, read_profile

_PROFILE = """\
# Options that every command takes in this folder; an option on the command line wins.
robot = "{robot}.urdf"
tip = "{tip}"
limits = "{robot}.toml"
"""


def view(
    *,
    motion: options.MaybeMotion = None,
    robot: options.RobotName = "panda",
    details: options.ArmDetails,
    demonstrations: options.Demonstrations = None,
    skill: options.SkillPath = None,
    goal: str | None = None,
    obstacle: options.Obstacles = None,
    layout: options.ReadOptions,
    clean: bool = False,
    html: options.PagePath = None,
    port: int = 0,
) -> None:
    """Show an arm and its motion, live in a browser or as an HTML file that needs no server.

    leadthrough view motion.csv --robot ur3 --html motion.html

    leadthrough view --robot panda --skill skill.npz --obstacle box:0.1,0.1,0.4@0.5,0,0.2

    Options:
        motion: Motion to show: of the joints, or poses that the tip follows.
        demonstrations: Recording to draw, or a folder of them; may be repeated.
        skill: Skill file; in the live page its goal and obstacles can be dragged.
        goal: Goal of the skill: X,Y,Z in m, or a pose X,Y,Z/W,X,Y,Z.
        clean: Leave faults of the recordings out, as `leadthrough clean` does.
        html: Write the page to this HTML file instead of opening a browser.
        port: Port of the live page; 0 picks a free one.
    """
    from leadthrough import check
    from leadthrough.cli import parse, reading, robot as robots

    check.integer(port, "port", at_least=0, at_most=65535)
    arm = robots.load(robot, details)
    asked = None if motion is None else reading.one_motion(motion, joints=robots.ranges(arm))
    if isinstance(asked, lt.JointTrajectory):
        asked = robots.own_joints(arm, asked, str(motion))
    recordings = []
    if not demonstrations:
        robots.refuse("--demonstrations", **vars(layout))
    else:
        files, known = reading.listed(demonstrations), robots.ranges(arm)
        how = {**layout.arguments(), "joints": known}
        found = (
            reading.cleaned(files, **how)
            if clean
            else lt.read_demonstrations(files, **how, rest=math.inf)
        )
        recordings = [_of_the_arm(arm, each) for each in found]
    with output.naming(path="--html"):
        lt.show.view(
            arm,
            asked,
            demonstrations=recordings,
            skill=None if skill is None else reading.saved_skill(skill),
            goal=None if goal is None else parse.place(goal, "--goal"),
            scene=parse.obstacles(obstacle),
            html=html,
            port=port,
        )
    if html is not None:
        print(f"wrote {html}: open it in a browser")


def _of_the_arm(arm: lt.Arm, shown: lt.Demonstration) -> lt.Demonstration:
    """A recording with the names of the arm's joints, if it is of joints."""
    from leadthrough.cli import robot as robots

    if not isinstance(shown.motion, lt.JointTrajectory):
        return shown
    return replace(shown, motion=robots.own_joints(arm, shown.motion, shown.name))


def teach(
    *,
    ctx: typer.Context,
    robot: options.RobotName = "panda",
    details: options.ArmDetails,
    obstacle: options.Obstacles = None,
    out: Path = Path("recorded"),
    port: int = 0,
) -> None:
    """Lead an arm by its tip in the browser, record demonstrations, learn and correct a motion.

    Writes each demonstration when its recording ends, and leadthrough.toml for the other commands.

    leadthrough teach --robot ur3 --obstacle box:0.1,0.1,0.3@0.3,0.2,0.15

    Options:
        out: Folder for the demonstrations; those that are there already are listed.
        port: Port of the page; 0 picks a free one.
    """
    from leadthrough.cli import parse, questions, robot as robots
    from leadthrough.cli.start import write_profile

    arm = robots.load(robot, details)
    scene = parse.obstacles(obstacle)
    if read_profile().get("robot") != robot:
        write_profile(ctx, questions.taken, robot, details)
    recordings = [
        lt.Demonstration(robots.joints_in(arm, file), file.stem)
        for file in sorted(out.glob("*.csv"))
    ]
    with output.naming(port="--port", folder="--out"):
        page = lt.show.teach(arm, scene, folder=out, demonstrations=recordings, port=port)
    print(f"{page.url} teaches the arm; Ctrl-C ends it", flush=True)
    page.open()
    page.wait()
    if page.session.command:
        output.advise(page.session.command)


def demo(
    out: Path = Path("leadthrough-demo"),
    scene: list[str] | None = None,
    motion: list[str] | None = None,
) -> None:
    """Show three arms that learn: a UR3 writes, a Panda pours, a TIAGo harvests.

    Options:
        out: Folder for the results.
        scene: Scene to show: handwriting, pouring or harvesting; may be repeated. By default all
            three.
        motion: Motion of the LASA handwriting set, such as GShape; may be repeated. By default
            eight of them. The arm is shown with the first.
    """
    from leadthrough import check
    from leadthrough_studies.demo.performance import perform
    from leadthrough_studies.demo.scenes import NAMES

    names = [check.choice(name, "--scene", NAMES) for name in scene or ()]
    shown = perform(names, motion or (), out)
    console = Console()
    for table in shown.tables:
        console.print(_table(*table))
    # Plain: rich would take the extra's name in brackets for a style.
    print("\n".join(shown.remarks))
    if not shown.ok:
        raise typer.Exit(1)


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(*columns, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for row in rows:
        table.add_row(*row)
    return table


def example(
    ctx: typer.Context,
    name: options.ExampleName,
    folder: Annotated[Path, typer.Argument()],
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Write the files of an example, to try the commands on.

    reach: a UR3, its limits, and three recordings of a simulated person guiding it.

    leadthrough example reach first-steps

    Options:
        name: Name of the example: reach.
        folder: Folder to write it to; made if it is missing.
    """
    from leadthrough import check

    check.choice(name, "NAME", options.EXAMPLES)
    files = _reach(check.integer(seed, "seed", at_least=0))
    for path in files:
        if (folder / path).exists():
            raise lt.errors.InvalidInput(
                f"FOLDER: {folder / path} is there already; name another folder"
            )
    for path, content in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, str):
            (folder / path).write_text(content, encoding="utf-8")
        else:
            lt.io.write_motion(content.motion, folder / path)
    output.facts({"folder": str(folder), "files": list(files)}, as_json=as_json)
    if not as_json:
        here = "" if folder.resolve() == Path.cwd() else f"cd {output.quoted(folder)} && "
        output.advise(here + output.line(ctx, "info", "recorded"))


def _reach(seed: int) -> dict[str, str | lt.Demonstration]:
    """The files' contents by their paths in the folder."""
    from leadthrough.arm.robot_files import find_robot
    from leadthrough_studies.example import ROBOT, reaches

    arm, files = lt.Arm.load(ROBOT), find_robot(ROBOT)
    assert files.limits is not None  # the package's own have one
    recordings = reaches(arm.joint_names, seed=seed)
    return {
        f"{ROBOT}.urdf": files.urdf.read_text(encoding="utf-8"),
        f"{ROBOT}.toml": files.limits.read_text(encoding="utf-8"),
        PROFILE: _PROFILE.format(robot=ROBOT, tip=arm.tip),
        **{f"recorded/{shown.name}.csv": shown for shown in recordings},
    }
