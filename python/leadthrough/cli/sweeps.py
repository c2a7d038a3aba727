"""Commands of many tasks: `leadthrough validate`, `augment`, `reach` and `experiment`."""

from __future__ import annotations

from pathlib import Path

import typer
from rich.console import Console

import leadthrough as lt
from leadthrough.cli import options, output


def validate(
    *,
    skill: options.SkillFile,
    robot: options.RobotName,
    details: options.ArmDetails,
    goals: str | None = None,
    starts: str | None = None,
    obstacle: options.Obstacles = None,
    random_obstacle: list[str] | None = None,
    runs: int = 1000,
    width: float | None = None,
    required: float | None = None,
    physics: bool = False,
    margin: options.Margin = 0.005,
    seed: options.Seed = 0,
    out: Path | None = None,
    certify: options.SkillPath = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Measure how often the arm can run a skill's motion, for queries at random from regions.

    Each motion is planned, retimed and checked. The folder gets report.html, results.json and
    manifest.json; run the same command again to resume one that was stopped.

    leadthrough validate pour.npz --robot panda --goals 0.1,0.1,0.05 --runs 5000 --on local:4

    Options:
        goals: Region of the goals: the distances DX,DY,DZ to both sides of the demonstrated one, or
            two corners X,Y,Z:X,Y,Z (m, rad); /ANGLE appended rotates poses by up to so many rad.
        starts: Region of the starts, in the form of --goals.
        random_obstacle: Obstacle at a random position: one as of --obstacle, then ~DX,DY,DZ, how
            far it may be from there, in m. May be repeated.
        runs: Number of random queries.
        width: Stop once the success rate's confidence interval is at most this wide.
        required: Required success rate; exits with 1 if the lower confidence bound is below it.
        physics: Simulate each motion too; needs the extra simulation.
        out: Folder for the results; by default SKILL-validation.
        certify: Skill file to write with the certificate, an .npz; may be that of the skill.
    """
    from leadthrough.cli import parse, reading, robot as robots

    if certify is not None:
        reading.check_suffix(certify, reading.SKILL, "--certify")
    learned = reading.saved_skill(skill)
    fixed = parse.obstacles(obstacle)
    drawn = [parse.random_obstacle(text) for text in random_obstacle or ()]
    folder = out or skill.with_name(f"{skill.stem}-validation")
    with output.interruptible():
        found = lt.validate(
            learned,
            robots.load(robot, details),
            lt.Scene([*fixed, *drawn], margin),
            goals=_places(learned, goals, -1, "--goals"),
            starts=_places(learned, starts, 0, "--starts"),
            plan=lt.validation.SamplingPlan(
                runs, width, 0.95 if required is None else required, seed=seed
            ),
            controller=lt.simulation.ComputedTorque() if physics else None,
            execution=lt.tasks.Execution(on, folder, task_timeout, lt.tasks.with_progress),
        )
    lt.show.write_validation(folder, found)
    if certify is not None:
        learned.certified(found.certificate).save(certify)
    output.facts(_facts(found, folder), as_json=as_json, units={"margin": "m"})
    low = found.certificate.interval.lower
    if found.errors or (required is not None and low < required):
        raise typer.Exit(1)


def _facts(found: lt.validation.Validation, folder: Path) -> dict[str, object]:
    certificate = found.certificate
    causes = [f"{count} {cause}" for cause, count in certificate.causes.items()]
    facts: dict[str, object] = {
        "queries": certificate.runs,
        "succeeded": certificate.successes,
        "success_rate": certificate.fraction,
        "interval": [certificate.interval.lower, certificate.interval.upper],
        "method": f"{certificate.interval.method}, {certificate.interval.confidence:.0%}",
        "failures": causes,
        f"holds_{certificate.required:.0%}_in": str(certificate.holds or "no part of the goals"),
    }
    if found.nearest:
        facts["nearest_failure"] = f"goal {found.nearest.goal.round(4).tolist()}"
        facts["reasons"] = f"{found.nearest.cause}: {found.nearest.detail}"
    return {**facts, "report": str(folder / "report.html")}


def augment(
    *,
    skill: options.SkillFile,
    out: options.DataSetOutput,
    robot: options.RobotName,
    details: options.ArmDetails,
    episodes: int = 1000,
    goals: str | None = None,
    starts: str | None = None,
    obstacle: options.Obstacles = None,
    random_obstacle: list[str] | None = None,
    rate: float = 30.0,
    margin: options.Margin = 0.005,
    seed: options.Seed = 0,
    folder: Path | None = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Write a data set of a skill's motions, for queries at random from regions.

    Each motion is planned, inside all limits and clear; the others are counted by cause. Images are
    not made. Run the same command again to resume one that was stopped: the bytes are the same.

    leadthrough augment pour.npz --robot panda --goals 0.1,0.1,0.05 --episodes 1000 -o episodes

    Options:
        out: Folder to write, a LeRobot data set of version 3; or a file .hdf5 or .h5.
        episodes: Number of motions in the data set.
        goals: Region of the goals: the distances DX,DY,DZ to both sides of the demonstrated one, or
            two corners X,Y,Z:X,Y,Z (m, rad); /ANGLE appended rotates poses by up to so many rad.
        starts: Region of the starts, in the form of --goals.
        random_obstacle: Obstacle at a random position: one as of --obstacle, then ~DX,DY,DZ, how
            far it may be from there, in m. May be repeated.
        rate: Frames per second.
        folder: Folder for finished motions, from which the command resumes; by default OUT-motions.
            It may be deleted afterwards.
    """
    from leadthrough.cli import parse, reading, robot as robots

    learned = reading.saved_skill(skill)
    drawn = [parse.random_obstacle(text) for text in random_obstacle or ()]
    with output.interruptible():
        found = lt.augment(
            learned,
            robots.load(robot, details),
            lt.Scene([*parse.obstacles(obstacle), *drawn], margin),
            episodes=episodes,
            out=out,
            goals=_places(learned, goals, -1, "--goals"),
            starts=_places(learned, starts, 0, "--starts"),
            seed=seed,
            rate=rate,
            execution=lt.tasks.Execution(
                on,
                folder or out.with_name(f"{out.stem}-motions"),
                task_timeout,
                lt.tasks.with_progress,
            ),
        )
    facts: dict[str, object] = {
        "episodes": found.episodes,
        "frames": found.frames,
        "motions_tried": found.attempts,
        "left_out": [f"{count} {cause}" for cause, count in found.causes.items()],
        "data_set": str(found.path),
    }
    output.facts(facts, as_json=as_json)


def _places(
    learned: lt.models.Skill, text: str | None, index: int, name: str
) -> lt.models.TargetRegion | None:
    """The region that an option states; None where it is left out."""
    from leadthrough.cli import parse

    if text is None:
        return None
    return parse.places(text, learned.generate().positions[index], name)


def reach(
    *,
    robot: options.RobotName,
    out: options.SkillOutput,
    details: options.ArmDetails,
    volume: str | None = None,
    spacing: float = 0.1,
    orientations: int = 12,
    obstacle: options.Obstacles = None,
    skill: options.SkillPath = None,
    area: str | None = None,
    yaws: int = 8,
    seed: options.Seed = 0,
    folder: Path | None = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Map the positions that an arm's tip reaches, or find where to place the arm's base.

    leadthrough reach --robot panda --spacing 0.05 --on local:4 -o reach.npz

    leadthrough reach --robot ur3 --skill pour.npz --area=-0.5,-0.5,0:0.5,0.5,0 -o stand.npz

    Options:
        out: File to write, an .npz; a picture .png is written beside it.
        volume: Region that the tip is to reach: two corners X,Y,Z:X,Y,Z, in m; by default the whole
            reach.
        spacing: Distance between neighbouring positions, in m.
        orientations: Number of orientations that are tried at each position.
        skill: Skill of poses that the arm is to run; finds positions of the base.
        area: With --skill, where the base may stand in the frame of the skill's motion: two corners
            X,Y,Z:X,Y,Z, in m.
        yaws: With --skill, number of directions that the base may face.
        folder: Folder for finished results, from which the command resumes.
    """
    from leadthrough.cli import parse, reading, robot as robots

    reading.check_suffix(out, reading.SKILL, "--out")
    arm = robots.load(robot, details)
    if skill is not None or area is not None:
        _place(arm, skill, area, out, spacing, yaws, seed, as_json=as_json)
        return
    corners = None if volume is None else parse.corners(volume, "--volume")
    found = lt.reachability.reach_map(
        arm,
        volume=corners,
        spacing=spacing,
        orientations=orientations,
        scene=parse.obstacles(obstacle),
        seed=seed,
        execution=lt.tasks.Execution(on, folder, task_timeout, lt.tasks.with_progress),
    )
    found.save(out)
    picture = out.with_suffix(".png")
    lt.show.reach_figure(found).savefig(picture)
    facts = {
        "map": str(out),
        "picture": str(picture),
        "places": found.fraction.size,
        "reached": int((found.fraction > 0.0).sum()),
        "in_every_orientation": int((found.fraction == 1.0).sum()),
        "volume": found.volume,
        "best_manipulability": float(found.manipulability.max()),
    }
    output.facts(facts, as_json=as_json, units={"volume": "m^3"})


def _place(  # an option each
    arm: lt.Arm,
    skill: Path | None,
    area: str | None,
    out: Path,
    spacing: float,
    yaws: int,
    seed: int,
    *,
    as_json: bool,
) -> None:
    """Base positions from which an arm can run a skill; exits with code 1 if there are none."""
    from leadthrough.cli import parse, reading
    from leadthrough.io import npz

    if skill is None or area is None:
        missing, given = ("--area", "--skill") if area is None else ("--skill", "--area")
        raise lt.errors.InvalidInput(f"{missing}: needed with {given}")
    corners: lt.models.TargetRegion = parse.corners(area, "--area")
    learned = reading.saved_skill(skill)
    found = lt.reachability.place_base(
        learned, arm, area=corners, spacing=spacing, yaws=yaws, seed=seed
    )
    kept = ("bases", "fraction", "manipulability")
    npz.write_compressed(out, {name: getattr(found, name) for name in kept})
    picture = out.with_suffix(".png")
    lt.show.placement_figure(found).savefig(picture)
    facts: dict[str, object] = {
        "map": str(out),
        "picture": str(picture),
        "places": len(found.bases),
        "whole_motion_from": int((found.manipulability > 0.0).sum()),
        "best_base": None if found.best is None else found.best[:3].tolist(),
        "yaw": None if found.best is None else float(found.best[3]),
        "least_manipulability": float(found.manipulability.max()),
    }
    output.facts(facts, as_json=as_json, units={"best_base": "m", "yaw": "rad"})
    if found.best is None:
        raise typer.Exit(1)


def experiment(
    name: options.StudyName = None,
    quick: bool = False,
    out: Path | None = None,
    seed: options.Seed = 0,
    recordings: Path | None = None,
    jobs: int = 1,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
) -> None:
    """Run a study; results that are already in its folder are not computed again.

    leadthrough experiment lasa --quick --on tcp://host:8786

    Options:
        name: Name of the study; leave it out to list all studies.
        quick: Run a small part of the study.
        out: Folder for the results; by default leadthrough-NAME.
        recordings: Folder with sets of demonstrations, to run the study on these instead.
        jobs: Number of parallel processes; the same as --on local:N.
    """
    from leadthrough import check
    from leadthrough_studies import study
    from leadthrough_studies.catalogue import STUDIES

    if name is None:
        print("\n".join(STUDIES))
        return
    chosen = STUDIES[check.choice(name, "NAME", STUDIES)]
    folder = out or Path(f"leadthrough-{name}")
    config = chosen.configure(quick, check.integer(seed, "seed", at_least=0))
    if recordings is not None:
        if chosen.of_recordings is None:
            able = [each for each, one in STUDIES.items() if one.of_recordings is not None]
            raise check.InvalidInput(
                f"--recordings: expected the study {' or '.join(able)}, got {name}"
            )
        config = chosen.of_recordings(config, recordings)
    place = on or f"local:{check.integer(jobs, 'jobs', at_least=1)}"
    with output.interruptible():
        outcome = study.run(chosen, config, out=folder, on=place, task_timeout=task_timeout)
    console = Console()
    if outcome.report.table:
        console.print(output.table(outcome.report.table))
    print(f"results.json, table.csv and figures: {folder}/")
    for page in outcome.report.pages:
        print(f"Page to open in a browser: {folder / page}.html")
    if simulated := outcome.report.summary.get("simulated"):
        print(f"Under gravity and a controller: {simulated}")
    for failure in outcome.failures:
        failed = f"failed: {failure['task']}: {failure['error']}: {failure['message']}"
        console.print(failed, style="red", markup=False)
    if outcome.failures:
        raise typer.Exit(1)
