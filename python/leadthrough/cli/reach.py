"""`leadthrough reach`: what an arm reaches, and where it must stand for a skill."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import completion, options

if TYPE_CHECKING:
    from leadthrough.arm import Arm
    from leadthrough.models.places import Places

_CORNERS = "two corners X,Y,Z:X,Y,Z, in m"


def reach(
    robot: options.RobotName,
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            help="File to write, an .npz; a picture .png is written beside it.",
            autocompletion=completion.files(".npz"),
        ),
    ],
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    volume: Annotated[
        str | None,
        typer.Option(help=f"Where the tip is to reach: {_CORNERS}; by default the whole reach."),
    ] = None,
    spacing: Annotated[
        float, typer.Option(help="Distance between neighbouring places, in m.")
    ] = 0.1,
    orientations: Annotated[
        int, typer.Option(help="Number of orientations that are tried at each place.")
    ] = 12,
    obstacle: options.Obstacles = None,
    skill: Annotated[
        Path | None,
        typer.Option(
            help="Skill of poses that the arm is to run; finds where it must stand.",
            autocompletion=completion.files(".npz"),
        ),
    ] = None,
    area: Annotated[
        str | None,
        typer.Option(
            help="With --skill, where the base may stand in the frame of the skill's motion: "
            f"{_CORNERS}."
        ),
    ] = None,
    yaws: Annotated[
        int, typer.Option(help="With --skill, number of directions that the base may face.")
    ] = 8,
    seed: options.Seed = 0,
    folder: Annotated[
        Path | None, typer.Option(help="Folder that keeps what is computed, to go on there.")
    ] = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Map where an arm's tip can be and how well it moves there; or find where it must stand.

    leadthrough reach --robot panda --spacing 0.05 --on local:4 -o reach.npz

    leadthrough reach --robot ur3 --skill pour.npz --area=-0.5,-0.5,0:0.5,0.5,0 -o stand.npz
    """
    from leadthrough import tasks
    from leadthrough.cli import parse, reading, tables
    from leadthrough.cli import robot as robots
    from leadthrough.reachability import reach_map
    from leadthrough.show.reach_picture import reach_figure

    reading.check_skill_output(out)
    arm = robots.load(robot, limits, base, tip, mesh_folder)
    if skill is not None or area is not None:
        _place(arm, skill, area, out, spacing, yaws, seed, as_json=as_json)
        return
    corners = None if volume is None else parse.corners(volume, "--volume")
    found = reach_map(
        arm,
        volume=corners,
        spacing=spacing,
        orientations=orientations,
        scene=[parse.obstacle(text) for text in obstacle or ()],
        seed=seed,
        on=on,
        out=folder,
        task_timeout=task_timeout,
        progress=tasks.with_progress,
    )
    found.save(out)
    picture = out.with_suffix(".png")
    reach_figure(found).savefig(picture)
    told = {
        "map": str(out),
        "picture": str(picture),
        "places": found.fraction.size,
        "reached": int((found.fraction > 0.0).sum()),
        "in_every_orientation": int((found.fraction == 1.0).sum()),
        "volume": found.volume,
        "best_manipulability": float(found.manipulability.max()),
    }
    tables.facts(told, as_json=as_json, units={"volume": "m^3"})


def _place(  # an option each
    arm: Arm,
    skill: Path | None,
    area: str | None,
    out: Path,
    spacing: float,
    yaws: int,
    seed: int,
    *,
    as_json: bool,
) -> None:
    """Where the arm must stand for a skill; exits with code 1 where there is no such place."""
    import numpy as np

    from leadthrough.cli import parse, reading, tables
    from leadthrough.errors import InvalidInput
    from leadthrough.io.atomic import replacing
    from leadthrough.reachability import place_base
    from leadthrough.show.reach_picture import placement_figure

    if skill is None or area is None:
        missing, given = ("--area", "--skill") if area is None else ("--skill", "--area")
        raise InvalidInput(f"{missing}: needed with {given}")
    corners: Places = parse.corners(area, "--area")
    learned = reading.saved_skill(skill)
    found = place_base(learned, arm, area=corners, spacing=spacing, yaws=yaws, seed=seed)
    with replacing(out) as temporary, temporary.open("wb") as file:
        np.savez_compressed(
            file,
            allow_pickle=False,
            bases=found.bases,
            fraction=found.fraction,
            manipulability=found.manipulability,
        )
    picture = out.with_suffix(".png")
    placement_figure(found).savefig(picture)
    told: dict[str, object] = {
        "map": str(out),
        "picture": str(picture),
        "places": len(found.bases),
        "whole_motion_from": int((found.manipulability > 0.0).sum()),
        "best_base": None if found.best is None else found.best[:3].tolist(),
        "yaw": None if found.best is None else float(found.best[3]),
        "least_manipulability": float(found.manipulability.max()),
    }
    tables.facts(told, as_json=as_json, units={"best_base": "m", "yaw": "rad"})
    if found.best is None:
        raise typer.Exit(1)
