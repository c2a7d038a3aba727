"""`leadthrough example`: files to try the commands on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import completion, options, profile
from leadthrough.errors import InvalidInput

if TYPE_CHECKING:
    from leadthrough.motion import Demonstration

NAMES = ("reach",)
_PROFILE = """\
# Options that every command takes in this folder; an option on the command line wins.
robot = "{robot}.urdf"
tip = "{tip}"
limits = "{robot}.toml"
"""


def example(
    ctx: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            help="Name of the example: reach.", autocompletion=completion.one_of(*NAMES)
        ),
    ],
    folder: Annotated[Path, typer.Argument(help="Folder to write it to; made if it is missing.")],
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Write the files of an example, to try the commands on.

    reach: a UR3, its limits, and three recordings of a simulated person guiding it.

    leadthrough example reach first-steps
    """
    from leadthrough import check, io
    from leadthrough.cli import chain, tables

    check.choice(name, "NAME", NAMES)
    files = _reach(check.integer(seed, "seed", at_least=0))
    for path in files:
        if (folder / path).exists():
            raise InvalidInput(f"FOLDER: {folder / path} is there already; name another folder")
    for path, content in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, str):
            (folder / path).write_text(content, encoding="utf-8")
        else:
            io.write_motion(content.motion, folder / path)
    tables.facts({"folder": str(folder), "files": list(files)}, as_json=as_json)
    if not as_json:
        here = () if folder.resolve() == Path.cwd() else ("cd", folder, "&&")
        chain.hint(ctx, *here, "leadthrough", "info", "shown")


def _reach(seed: int) -> dict[str, str | Demonstration]:
    """The files' contents by their paths in the folder."""
    from leadthrough.arm import Arm
    from leadthrough.arm.robot_files import find_robot
    from leadthrough_studies.example import ROBOT, reaches

    arm, files = Arm.load(ROBOT), find_robot(ROBOT)
    assert files.limits is not None  # the package's own have one
    recordings = reaches(arm.joint_names, seed=seed)
    return {
        f"{ROBOT}.urdf": files.urdf.read_text(encoding="utf-8"),
        f"{ROBOT}.toml": files.limits.read_text(encoding="utf-8"),
        profile.FILE: _PROFILE.format(robot=ROBOT, tip=arm.tip),
        **{f"shown/{shown.name}.csv": shown for shown in recordings},
    }
