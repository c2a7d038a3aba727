"""`leadthrough info`: what files contain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadthrough.cli import chain, completion, options, profile
from leadthrough.errors import InvalidInput

if TYPE_CHECKING:
    from leadthrough.show.info import FileInfo

_URDF = (".urdf", ".xml")


def info(
    ctx: typer.Context,
    files: Annotated[
        list[Path],
        typer.Argument(
            help="Recordings, motions, skills, ROS bags, data sets or URDFs, or folders of them.",
            autocompletion=completion.anything,
        ),
    ],
    column: options.Columns = None,
    rate: options.Rate = None,
    angles: options.Angles = None,
    quaternions: options.Quaternions = None,
    topic: options.Topic = None,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    write_limits: Annotated[
        Path | None,
        typer.Option(
            help="Write a limits file for the URDF, with assumed accelerations and jerks where "
            "none are stated."
        ),
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Show what files contain, and report faults in recordings.

    leadthrough info day.csv --rate 50

    leadthrough info recorded.mcap skill.npz ur5.urdf

    leadthrough info ur5.urdf --tip tool0 --write-limits ur5.toml
    """
    import json

    from leadthrough.cli import parse, reading
    from leadthrough.cli import robot as robots
    from leadthrough.io.table import as_request
    from leadthrough.show.info import describe

    found = reading.listed(files, also=_URDF)
    if not any(file.suffix.lower() in _URDF for file in found):
        robots.refuse(
            "a URDF among the files", limits=limits, base=base, tip=tip, mesh_folder=mesh_folder
        )
    if write_limits is not None:
        limits = _write_limits(ctx, found, write_limits)
    asked = as_request(
        columns=parse.columns(column or []),
        rate=rate,
        angles=angles,
        quaternions=quaternions,
        topic=topic,
        frames=None,
    )
    given = {"limits": limits, "base": base, "tip": tip, "mesh_folder": mesh_folder}
    told = [
        _in_words(ctx, describe(file, request=asked, **_arm(ctx, file, given))) for file in found
    ]
    if as_json:
        print(json.dumps([each.as_dict() for each in told], allow_nan=False))
        return
    print("\n\n".join(map(str, told)))
    if write_limits is not None:
        print(f"wrote {write_limits}: replace the assumed values with the maker's")
    if len({each.kind for each in told}) == 1 and not any(each.problem for each in told):
        chain.hint(ctx, *_next(ctx, told, write_limits))


def _in_words(ctx: typer.Context, found: FileInfo) -> FileInfo:
    """The summary, whose remarks name options."""
    from leadthrough.cli import command, errors

    words = command.words(ctx)
    recordings = tuple(
        replace(each, remarks=tuple(errors.in_words(text, words) for text in each.remarks))
        for each in found.recordings
    )
    problem = found.problem and errors.in_words(found.problem, words)
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
    """What was typed; for the robot of the profile, what the profile states besides."""
    typed = {name: str(value) for name, value in given.items() if value is not None}
    if file.suffix.lower() not in _URDF or ctx.find_root().params["no_profile"]:
        return typed
    stated = profile.read()
    is_the_robot = Path(stated.pop("robot", "")).absolute() == file.absolute()
    return {**stated, **typed} if is_the_robot else typed


def _write_limits(ctx: typer.Context, files: Sequence[Path], target: Path) -> Path:
    from leadthrough.arm import Arm
    from leadthrough.arm.description import limits_file

    if len(files) != 1 or files[0].suffix.lower() not in _URDF:
        raise InvalidInput(f"--write-limits: expected one URDF, got {', '.join(map(str, files))}")
    if target.exists():
        raise InvalidInput(f"--write-limits: {target} is there already; name another file")
    links = _arm_options(ctx, files[0], {name: ctx.params[name] for name in ("base", "tip")})
    base, tip = links.get("base"), links.get("tip")
    # Not the profile's limits, which may be the ones to write.
    arm = Arm.from_urdf(files[0], base=base, tip=tip, limits=ctx.params["limits"])
    target.write_text(limits_file(arm), encoding="utf-8")
    return target


def _next(
    ctx: typer.Context, told: Sequence[FileInfo], written: Path | None
) -> tuple[str | Path, ...]:
    """The command for these files, which are of one kind."""
    if told[0].kind == "skill":
        return ("leadthrough", "plan", told[0].path, "-o", "motion.csv")
    if told[0].kind == "recordings":
        faulty = any(recording.has_faults for each in told for recording in each.recordings)
        asked = ctx.params["files"]
        return (
            "leadthrough",
            "learn",
            *asked,
            *chain.reading(ctx),
            *["--clean"] * faulty,
            "-o",
            "skill.npz",
        )
    return _next_of_robot(ctx, told[0], written)


def _next_of_robot(
    ctx: typer.Context, robot: FileInfo, written: Path | None
) -> tuple[str | Path, ...]:
    typed = {name: ctx.params[name] for name in profile.OF_THE_ROBOT}
    if robot.facts["unknown_limits"]:
        target = Path(robot.path).with_suffix(".toml").name
        arm = chain.options(base=typed["base"], tip=typed["tip"])
        return ("leadthrough", "info", robot.path, *arm, "--write-limits", target)
    asked = _arm_options(ctx, Path(robot.path), {**typed, "limits": written or typed["limits"]})
    is_in_profile = asked and not any(typed.values()) and written is None
    arm = () if is_in_profile else chain.options(robot=robot.path, **asked)
    return ("leadthrough", "learn", "RECORDINGS", *arm, "-o", "skill.npz")
