"""Commands about recordings: `leadthrough info`, `clean` and `judge`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

import leadthrough as lt
from leadthrough.cli import options, output
from leadthrough.cli.command import OF_THE_ROBOT, read_profile

if TYPE_CHECKING:
    from leadthrough.cli.file_info import FileInfo

_URDF = (".urdf", ".xml", ".xacro")


def info(
    *,
    ctx: typer.Context,
    files: options.AnyFiles,
    layout: options.ReadOptions,
    details: options.ArmDetails,
    write_limits: Path | None = None,
    as_json: options.AsJson = False,
) -> None:
    """Show what files contain, and report faults in recordings.

    leadthrough info day.csv --rate 50

    leadthrough info recorded.mcap skill.npz ur5.urdf

    leadthrough info ur5.urdf --tip tool0 --write-limits ur5.toml

    Options:
        files: Recordings, motions, skills, ROS bags, data sets or URDFs, or folders of them.
        write_limits: Write a limits file for the URDF, with assumed accelerations and jerks where
            none are stated.
    """
    import json

    from leadthrough.cli import reading, robot as robots
    from leadthrough.cli.file_info import describe

    found = reading.listed(files, also=_URDF)
    if not any(file.suffix.lower() in _URDF for file in found):
        robots.refuse("a URDF among the files", **vars(details))
    if write_limits is not None:
        details = replace(details, limits=_write_limits(ctx, found, write_limits))
    asked = layout.request()
    given = vars(details)
    infos = [
        _in_words(ctx, describe(file, request=asked, **_arm(ctx, file, given))) for file in found
    ]
    unreadable = any(each.problem for each in infos)
    if as_json:
        print(json.dumps([each.as_dict() for each in infos], allow_nan=False))
        raise typer.Exit(int(unreadable))
    print("\n\n".join(map(str, infos)))
    if unreadable:
        raise typer.Exit(1)
    if write_limits is not None:
        print(f"wrote {write_limits}: replace the assumed values with the maker's")
    if len({each.kind for each in infos}) == 1 and infos[0].facts.get("tip", "") is not None:
        output.hint(ctx, *_next(ctx, infos, write_limits))


def _in_words(ctx: typer.Context, found: FileInfo) -> FileInfo:
    """The summary, whose remarks name options."""
    from leadthrough.cli import command

    words = command.words(ctx)
    recordings = tuple(
        replace(each, remarks=tuple(output.in_words(text, words) for text in each.remarks))
        for each in found.recordings
    )
    problem = found.problem and output.in_words(found.problem, words)
    return replace(found, recordings=recordings, problem=problem)


def _arm(ctx: typer.Context, file: Path, given: Mapping[str, Path | str | None]) -> dict[str, Any]:
    """The options of a URDF's arm, as the library takes them."""
    from leadthrough.cli import robot as robots

    options = _arm_options(ctx, file, given)
    folder = options.pop("mesh_folder", None)
    return {**options, "mesh_folders": robots.mesh_folders(Path(folder) if folder else None)}


def _arm_options(
    ctx: typer.Context, file: Path, given: Mapping[str, Path | str | None]
) -> dict[str, str]:
    """The typed options; for the profile's robot, also the profile's."""
    typed = {name: str(value) for name, value in given.items() if value is not None}
    if file.suffix.lower() not in _URDF or ctx.find_root().params["no_profile"]:
        return typed
    stated = read_profile()
    is_the_robot = Path(stated.pop("robot", "")).absolute() == file.absolute()
    return {**stated, **typed} if is_the_robot else typed


def _write_limits(ctx: typer.Context, files: Sequence[Path], target: Path) -> Path:
    from leadthrough.arm.description import limits_file

    if len(files) != 1 or files[0].suffix.lower() not in _URDF:
        raise lt.errors.InvalidInput(
            f"--write-limits: expected one URDF, got {', '.join(map(str, files))}"
        )
    if target.exists():
        raise lt.errors.InvalidInput(
            f"--write-limits: {target} is there already; name another file"
        )
    links = _arm_options(ctx, files[0], {name: ctx.params[name] for name in ("base", "tip")})
    base, tip = links.get("base"), links.get("tip")
    # Not the profile's limits, which may be the ones to write.
    arm = lt.Arm.from_urdf(files[0], base=base, tip=tip, limits=ctx.params["limits"])
    target.write_text(limits_file(arm), encoding="utf-8")
    return target


def _next(
    ctx: typer.Context, infos: Sequence[FileInfo], written: Path | None
) -> tuple[str | Path, ...]:
    """The command for these files, which are of one kind."""
    if infos[0].kind == "skill":
        return ("plan", infos[0].path, "-o", "motion.csv")
    if infos[0].kind == "recordings":
        faulty = any(recording.has_faults for each in infos for recording in each.recordings)
        how = (*options.reading_words(ctx), *["--clean"] * faulty)
        return ("learn", *ctx.params["files"], *how, "-o", "skill.npz")
    return _next_of_robot(ctx, infos[0], written)


def _next_of_robot(
    ctx: typer.Context, robot: FileInfo, written: Path | None
) -> tuple[str | Path, ...]:
    if "ends" in robot.facts:
        return ("info", robot.path, "--tip", str(robot.facts["tip"]))
    typed = {name: ctx.params[name] for name in OF_THE_ROBOT}
    if robot.facts["unknown_limits"]:
        target = Path(robot.path).with_suffix(".toml").name
        arm = output.words(base=typed["base"], tip=typed["tip"])
        return ("info", robot.path, *arm, "--write-limits", target)
    asked = _arm_options(ctx, Path(robot.path), {**typed, "limits": written or typed["limits"]})
    is_in_profile = asked and not any(typed.values()) and written is None
    arm = () if is_in_profile else output.words(robot=robot.path, **asked)
    return ("learn", "RECORDINGS", *arm, "-o", "skill.npz")


def clean(
    *,
    ctx: typer.Context,
    files: options.Recordings,
    out: options.Output,
    layout: options.ReadOptions,
    longest_gap: float = 0.5,
    longest_pause: float | None = None,
    pause: options.Pause = None,
    resting: options.RestOptions,
    new_rate: float | None = None,
    smoothing: float | None = None,
    table: options.FaultTable = None,
    as_json: options.AsJson = False,
) -> None:
    """Remove faulty samples from recordings and report what was removed.

    If there are several recordings, each is written to its own numbered file.

    leadthrough clean day.csv --longest-pause 0.3 --smoothing 0.2 -o clean.csv

    Options:
        longest_gap: Longest time without samples to accept, in s; more is an error.
        longest_pause: Shorten longer pauses to this, in s; by default pauses are kept.
        new_rate: Resample at this rate, in Hz.
        smoothing: Smoothing window, in s; also adds velocities to joint motions.
    """
    import json
    from functools import partial

    from leadthrough import check
    from leadthrough.cli import reading

    reading.check_output(out)
    if new_rate is not None:
        check.number(new_rate, "--new-rate", above=0.0)
    clean_one: Any = lt.preprocess.clean  # mypy takes the first ** for positional arguments
    cleaned = partial(
        clean_one,
        **({} if pause is None else {"pause": pause}),
        longest_gap=longest_gap,
        longest_pause=longest_pause,
        **vars(resting),
        rate=new_rate,
        smoothing=smoothing,
    )
    if table is not None:
        reading.check_suffix(table, reading.TABLE, "--table")
        stream = lt.io.stream_recordings(reading.listed(files), **layout.arguments())
        results = reading.cleaned_episodes(stream, cleaned, table)
    else:
        recordings = lt.io.read_recordings(reading.listed(files), **layout.arguments())
        done = []
        for each in recordings:
            with output.naming(recording=each.name):
                done.append(cleaned(each))
        results = ((number, *each) for number, each in enumerate(done, start=1))
    several = table is not None or len(done) > 1
    files_written = []
    found = []
    for number, demonstration, report in results:
        path = out.with_name(f"{out.stem}_{number}{out.suffix}") if several else out
        lt.io.write_motion(demonstration.motion, path)
        files_written.append(path)
        if as_json:
            entry = {"recording": demonstration.name, "file": str(path), "report": report.as_dict()}
            found.append(entry)
        elif table is None:
            print(f"{demonstration.name}: {path}\n{report}")
    if as_json:
        print(json.dumps(found, allow_nan=False))
    elif table is not None:
        print(f"{len(files_written)} recordings cleaned; faults: {table}")
    else:
        output.hint(ctx, "learn", *files_written, "-o", "skill.npz")


def judge(
    *,
    files: options.Recordings,
    model: options.Model = None,
    parameter: options.Parameters = None,
    goals: str | None = None,
    resting: options.RestOptions,
    layout: options.ReadOptions,
    seed: options.Seed = 0,
    out: Path | None = None,
    on: options.On = None,
    task_timeout: options.TaskTimeout = None,
    as_json: options.AsJson = False,
) -> None:
    """Report which recordings of a motion are faulty or unlike the others, and the worth of each.

    leadthrough judge recorded/*.csv --goals 0.1,0.1,0.05

    Options:
        model: Model that is learned with one recording left out after the other, as of `leadthrough
            learn`; by default promp.
        parameter: Parameter of the model, such as weights=80; may be repeated.
        goals: Region in which the next demonstration may end, to suggest where: distances DX,DY,DZ
            to both sides of the recordings' mean goal, or two corners X,Y,Z:X,Y,Z.
        out: Folder for finished results, from which the command resumes.
    """
    import numpy as np

    from leadthrough.cli import parse, reading
    from leadthrough.cli.learn import model_of

    recordings = reading.listed(files)
    reading.refuse_skills(recordings)
    demonstrations = lt.read_demonstrations(recordings, **layout.arguments(), rest=math.inf)
    demonstrations = reading.trimmed(demonstrations, resting)
    middle = np.mean([each.motion.positions[-1] for each in demonstrations], axis=0)
    with output.busy("judging"), output.naming(demonstrations="RECORDINGS"):
        found = lt.judge_demonstrations(
            demonstrations,
            model=model_of(model or "promp", parse.parameters(parameter or [])),
            goals=None if goals is None else parse.places(goals, middle, "--goals"),
            seed=seed,
            on=on,
            out=out,
            task_timeout=task_timeout,
        )
    _print(found, as_json=as_json)


def _print(found: lt.demonstration_quality.Judgement, *, as_json: bool) -> None:

    rows = [
        {
            "recording": each.name,
            "suspicion": each.suspicion,
            "faults": ", ".join(each.faults),
            "worth": each.worth,
            "leave_out": each.remove,
        }
        for each in found.verdicts
    ]
    facts: dict[str, object] = {"recordings": rows} if as_json else {}
    facts |= {"left_out_error": found.error, "without_those": found.error_without}
    if found.next is not None:
        facts |= {"show_next": found.next.goal.tolist(), "uncertainty": found.next.uncertainty}
    if not as_json:
        Console().print(output.table(rows))
    output.facts(facts, as_json=as_json)
