"""`leadthrough validate`: how often a skill's motions succeed on an arm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import completion, options

if TYPE_CHECKING:
    from leadthrough.models.places import Places
    from leadthrough.models.protocol import Skill
    from leadthrough.validation import Validation

_FORM = (
    "the distances DX,DY,DZ to both sides of the demonstrated one, or two corners X,Y,Z:X,Y,Z (m, "
    "rad); /ANGLE appended turns poses by up to so many rad."
)


def validate(
    skill: options.SkillFile,
    robot: options.RobotName,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    goals: Annotated[str | None, typer.Option(help=f"Region of the goals: {_FORM}")] = None,
    starts: Annotated[
        str | None, typer.Option(help="Region of the starts, in the form of --goals.")
    ] = None,
    obstacle: options.Obstacles = None,
    random_obstacle: Annotated[
        list[str] | None,
        typer.Option(
            help="Obstacle at a random position: one as of --obstacle, then ~DX,DY,DZ, how far it "
            "may be from there, in m. May be repeated.",
        ),
    ] = None,
    runs: Annotated[int, typer.Option(help="Number of random queries.")] = 1000,
    width: Annotated[
        float | None,
        typer.Option(help="Stop once the success rate's confidence interval is at most this wide."),
    ] = None,
    required: Annotated[
        float | None,
        typer.Option(
            help="Required success rate; exits with 1 if the lower confidence bound is below it."
        ),
    ] = None,
    physics: Annotated[
        bool,
        typer.Option("--physics", help="Simulate each motion too; needs the extra simulation."),
    ] = False,
    margin: options.Margin = 0.005,
    seed: options.Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; by default SKILL-validation.")
    ] = None,
    certify: Annotated[
        Path | None,
        typer.Option(
            help="Skill file to write with the certificate, an .npz; may be that of the skill.",
            autocompletion=completion.files(".npz"),
        ),
    ] = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Measure how often the arm can run a skill's motion, for queries at random from regions.

    Each motion is planned, retimed and checked. The folder gets report.html, results.json and
    manifest.json; run the same command again to go on with one that was stopped.

    leadthrough validate pour.npz --robot panda --goals 0.1,0.1,0.05 --runs 5000 --on local:4
    """
    from leadthrough import tasks
    from leadthrough.cli import errors, parse, reading, tables
    from leadthrough.cli import robot as robots
    from leadthrough.shapes import Scene
    from leadthrough.show.validation_page import write_validation
    from leadthrough.simulation import ComputedTorque
    from leadthrough.validation import validate as validated

    if certify is not None:
        reading.check_skill_output(certify, "--certify")
    learned = reading.saved_skill(skill)
    fixed = [parse.obstacle(text) for text in obstacle or ()]
    drawn = [parse.random_obstacle(text) for text in random_obstacle or ()]
    folder = out or skill.with_name(f"{skill.stem}-validation")
    with errors.going_on():
        found = validated(
            learned,
            robots.load(robot, limits, base, tip, mesh_folder),
            Scene([*fixed, *drawn], margin),
            goals=_places(learned, goals, -1, "--goals"),
            starts=_places(learned, starts, 0, "--starts"),
            runs=runs,
            width=width,
            required=0.95 if required is None else required,
            controller=ComputedTorque() if physics else None,
            seed=seed,
            on=on,
            out=folder,
            task_timeout=task_timeout,
            progress=tasks.with_progress,
        )
    write_validation(folder, found)
    if certify is not None:
        learned.certified(found.certificate).save(certify)
    tables.facts(_facts(found, folder), as_json=as_json, units={"margin": "m"})
    low = found.certificate.interval[0]
    if found.errors or (required is not None and low < required):
        raise typer.Exit(1)


def _facts(found: Validation, folder: Path) -> dict[str, object]:
    certificate = found.certificate
    causes = [f"{count} {cause}" for cause, count in certificate.causes.items()]
    told: dict[str, object] = {
        "queries": certificate.runs,
        "succeeded": certificate.successes,
        "success_rate": certificate.fraction,
        "interval": list(certificate.interval),
        "method": f"{certificate.method}, {certificate.confidence:.0%}",
        "failures": causes,
        f"holds_{certificate.required:.0%}_in": str(certificate.holds or "no part of the goals"),
    }
    if found.nearest:
        told["nearest_failure"] = f"goal {found.nearest.goal.round(4).tolist()}"
        told["reasons"] = f"{found.nearest.cause}: {found.nearest.detail}"
    return {**told, "report": str(folder / "report.html")}


def _places(learned: Skill, text: str | None, index: int, name: str) -> Places | None:
    """The region that an option states; None where it is left out."""
    from leadthrough.cli import parse

    if text is None:
        return None
    return parse.places(text, learned.generate().positions[index], name)
