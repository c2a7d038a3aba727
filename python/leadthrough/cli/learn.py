"""`leadthrough learn`: recordings in, a skill out."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

import leadthrough as lt
from leadthrough.cli import options, output

# Fraction of the extent from which on a demonstration counts as not reproduced.
_SOUND = 0.01
_JUDGED = 2  # recordings that `judge` needs
_MIN_NOISE = 1e-6  # m or rad
_ALIGN = "preprocess.align_by_time_warping"
_SPACE = 3  # coordinates of points in m; drawings have two, in their own unit
_WINDOW = 0.05  # s, over which a speed is taken, so that noise does not count
_QUANTILE = 0.999  # of a recording's speeds; the few above it are spikes
# A difference of two samples exceeds so many deviations of their noise once in 1,000: 3.3 sqrt(2).
_SPREAD = 4.7
_NAMES = {"PoseTrajectory": "poses", "Trajectory": "points", "JointTrajectory": "joints"}


def learn(
    *,
    ctx: typer.Context,
    files: options.Recordings,
    out: options.SkillOutput,
    model: options.ModelToFit = None,
    parameter: options.Parameters = None,
    robot: options.MaybeRobotName = None,
    details: options.ArmDetails,
    clean: bool = False,
    cut: bool = False,
    number: Annotated[list[int] | None, typer.Option("--motion")] = None,
    resting: options.RestOptions,
    pause: options.Pause = None,
    drop: Annotated[list[str] | None, typer.Option()] = None,
    align: bool = False,
    as_joints: Annotated[bool, typer.Option("--joints")] = False,
    layout: options.ReadOptions,
    table: options.FaultTable = None,
    samples: int = 200,
    as_json: options.AsJson = False,
) -> None:
    """Learn a skill from recordings; with --robot, joints are learned as poses of the tip.

    leadthrough learn recorded/*.csv --robot panda -o pour.npz

    leadthrough learn day.csv --cut --motion 3 --rate 50 --model fast-marching -o reach.npz

    Options:
        out: Skill file to write, an .npz.
        parameter: Parameter of the model, such as weights=80; may be repeated.
        clean: Remove faulty samples first; stderr reports them.
        cut: Split recordings into motions at pauses.
        number: Number of the motion to learn, counted from 1; may be repeated. By default all.
        drop: Name of a recording to leave out, such as one that contradicts the others; may be
            repeated.
        align: Bring the recordings to their mean timing first.
        as_joints: With --robot, learn its joints instead of poses of its tip.
        samples: With --table, most samples that are kept of each recording.
    """
    from leadthrough import check
    from leadthrough.cli import reading, robot as robots
    from leadthrough.models.protocol import fit_all

    reading.check_suffix(out, reading.SKILL, "--out")
    if model is not None:
        check.choice(model, "--model", lt.models.model_names())
    arm = None if robot is None else robots.load(robot, details)
    if arm is None:
        only = {"joints": as_joints or None}
        robots.refuse("--robot", **vars(details), **only)
    recordings = reading.listed(files)
    reading.refuse_skills(recordings)
    how = layout.arguments() | {"joints": None if arm is None else robots.ranges(arm)}
    if table is None:
        # Both ends stay: `reading.trimmed` has the options for them.
        read = reading.cleaned if clean else partial(lt.read_demonstrations, rest=math.inf)
        demonstrations = read(recordings, **how)
    else:
        most = check.integer(samples, "samples", at_least=10)
        demonstrations = reading.streamed(recordings, how, table, most)
    if cut:
        demonstrations = reading.cut(demonstrations, resting, pause=pause)
    else:
        robots.refuse("--cut", pause=pause)
    demonstrations = reading.trimmed(_chosen(demonstrations, number), resting)
    demonstrations = _without(demonstrations, drop or [])
    if arm is not None:
        demonstrations = _of_the_arm(ctx, arm, demonstrations, as_joints=as_joints)
    if align:
        demonstrations = lt.preprocess.align_by_time_warping(demonstrations)
    chosen = _asked_for(model, parameter, demonstrations)
    words = {f"demonstrations[{i}]": each.name for i, each in enumerate(demonstrations)}
    words |= {_ALIGN: "--align"} | ({} if chosen is None else options.of_model(chosen))
    with output.busy("learning"), output.naming(**words, path="--out"):
        if "rhythmic" not in repr(chosen).lower():  # a rhythm may be any number of periods long
            _refuse_contradictions(ctx, demonstrations)
        with _reporting(ctx, demonstrations):
            fit = partial(lt.learn, outliers="keep") if chosen is None else partial(fit_all, chosen)
            skill = fit(demonstrations)
            near = lt.models.reproduction(skill, demonstrations)
        skill.save(out)
    found: dict[str, Any] = {
        "skill": str(out),
        **_family(model, skill, as_json=as_json),
        "demonstrations": [each.name for each in demonstrations],
        "reproduction": near.as_dict() if as_json else _nearness(near, demonstrations),
        **_smoothed(skill, demonstrations, as_json=as_json),
    }
    output.facts(found, as_json=as_json)
    if not as_json:
        _hint(ctx, near, model)


def _smoothed(
    skill: lt.models.Skill, demonstrations: list[lt.Demonstration], *, as_json: bool
) -> dict[str, Any]:
    """How much white noise of the recordings the learned motion leaves out, in m or rad."""
    from leadthrough.noise import noise_of

    recorded = max(noise_of(each.motion.positions) for each in demonstrations)
    left_out = math.sqrt(max(recorded**2 - noise_of(skill.generate().positions) ** 2, 0.0))
    if left_out < _MIN_NOISE:
        return {}
    unit = "mrad" if isinstance(demonstrations[0].motion, lt.JointTrajectory) else "mm"
    return {"smoothed": left_out if as_json else f"noise of {1e3 * left_out:.2g} {unit}"}


def _asked_for(
    model: str | None, parameter: list[str] | None, demonstrations: list[lt.Demonstration]
) -> lt.models.Model | None:
    """The model of --model, if it learns such demonstrations; None without that option."""
    from leadthrough.cli import parse, robot as robots

    if model is None:
        robots.refuse("--model", set=parameter)
        return None
    chosen = model_of(model, parse.parameters(parameter or []))
    _refuse_other_kinds(model, demonstrations)
    return chosen


def _family(model: str | None, skill: lt.models.Skill, *, as_json: bool) -> dict[str, Any]:
    """The model that was learned and, unless it was asked for, the errors that chose it."""
    choice = getattr(skill, "choice", None)
    if model is not None or choice is None:
        return {"model": model}
    finite = {name: x if math.isfinite(x) else None for name, x in choice.errors.items()}
    errors = finite if as_json else choice.table
    return {"model": choice.chosen} | ({"left_out_errors": errors} if choice.left_out else {})


def _nearness(near: lt.models.Reproduction, demonstrations: Sequence[lt.Demonstration]) -> str:
    """The largest distance of a learned motion from its demonstration, in words."""
    failed = [
        each.name
        for each, apart in zip(demonstrations, near.positions, strict=True)
        if math.isinf(apart)
    ]
    if failed:
        return f"none from start to goal of {', '.join(failed)}"
    motion = demonstrations[0].motion
    unit, factor = ("rad", 1.0) if isinstance(motion, lt.JointTrajectory) else ("mm", 1e3)
    if motion.positions.shape[1] < _SPACE and unit == "mm":
        unit, factor = "", 1.0
    text = f"within {_short(factor * near.position)} {unit}".rstrip()
    if near.orientation is not None:
        text += f" and {_short(math.degrees(near.orientation))} degrees"
    first, *others = (each.name for each in demonstrations)
    between = " and " if len(others) == 1 else " .. "
    return f"{text} of {between.join([first, *others[-1:]])}"


def _short(number: float) -> str:
    """Two digits of a number, or its whole part where that has more."""
    return f"{number:.0f}" if number >= 10.0 else f"{number:.2g}"


def _hint(ctx: typer.Context, near: lt.models.Reproduction, model: str | None) -> None:
    """Prints the next command: a cure where demonstrations are not reproduced."""
    if near.fraction <= _SOUND or (model is None and len(near.positions) < _JUDGED):
        motion = "motion.csv" if ctx.params["robot"] is None else "motion.json"
        output.hint(ctx, "plan", ctx.params["out"], *output.arm_words(ctx), "-o", motion)
        return
    words: tuple[str | Path, ...] = ("judge", *ctx.params["files"], *options.reading_words(ctx))
    if len(near.positions) < _JUDGED:
        words = output.repeated(ctx, "model", "parameter", changed=())
    output.advise(output.line(ctx, *words))


def model_of(name: str, parameters: dict[str, Any]) -> lt.models.Model:
    """A model by its name on the command line; no other family is loaded."""
    from leadthrough import check

    kind = lt.models.model_entry(check.choice(name, "--model", lt.models.model_names())).load()
    for key in parameters:
        check.choice(key, "--set", kind.__dataclass_fields__)
    try:
        made: lt.models.Model = kind(**parameters)
    except lt.errors.InvalidInput as error:
        raise lt.errors.InvalidInput(f"--set {error}") from None
    return made


def _refuse_other_kinds(model: str, demonstrations: list[lt.Demonstration]) -> None:
    """Refuses demonstrations that are not of the type of motion that a model learns."""
    entry = lt.models.model_entry(model)
    for each in demonstrations:
        kind = _NAMES[type(each.motion).__name__]
        if kind not in entry.motions:
            instead = f"; use {entry.otherwise}" if entry.otherwise else ""
            raise lt.errors.InvalidInput(
                f"--model: {model} learns {' or '.join(entry.motions)}, and {each.name} has {kind}"
                f"{instead}"
            )


@contextmanager
def _reporting(ctx: typer.Context, demonstrations: list[lt.Demonstration]) -> Iterator[None]:
    """Prints each warning once on stderr, with names, of misaligned ones with the cure."""
    names = {f"demonstrations[{i}]": each.name for i, each in enumerate(demonstrations)}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield
    for message, category in dict.fromkeys((str(each.message), each.category) for each in caught):
        text = re.sub(
            r"demonstrations \[([\d, ]+)\]",
            lambda found: ", ".join(demonstrations[int(i)].name for i in found[1].split(",")),
            message,
        )
        text = output.in_words(text, {_ALIGN: "--align", **names})
        cure = output.line(ctx, *output.repeated(ctx, changed=("--align",)))
        misaligned = issubclass(category, lt.models.MisalignmentWarning)
        output.warn(f"{text}: {cure}" if misaligned else text)


def _chosen(
    demonstrations: list[lt.Demonstration], numbers: list[int] | None
) -> list[lt.Demonstration]:
    count = len(demonstrations)
    for number in numbers or ():
        if not 1 <= number <= count:
            raise lt.errors.InvalidInput(
                f"--motion: expected a number from 1 to {count}, got {number}"
            )
    return [demonstrations[number - 1] for number in numbers or range(1, count + 1)]


def _of_the_arm(
    ctx: typer.Context, arm: lt.Arm, recorded: Sequence[lt.Demonstration], *, as_joints: bool
) -> list[lt.Demonstration]:
    """The recordings with the arm's own joints, no faster than it can move, or its tip's poses."""
    from leadthrough.cli import robot as robots

    found, kept = dict[str, str](), []
    for each in recorded:
        motion = each.motion
        if isinstance(motion, lt.JointTrajectory):
            own = robots.own_joints(arm, motion, each.name)
            found[each.name] = _too_fast(arm, own)
            motion = own if as_joints else arm.poses(own)
        elif as_joints:
            raise lt.errors.InvalidInput(
                f"--joints: expected recordings of joints, {each.name} has none"
            )
        kept.append(replace(each, motion=motion))
    _refuse_named(ctx, {name: text for name, text in found.items() if text}, len(kept))
    return kept


def _without(
    demonstrations: Sequence[lt.Demonstration], names: list[str]
) -> list[lt.Demonstration]:
    from leadthrough import check

    known = [each.name for each in demonstrations]
    for name in names:
        check.choice(name, "--drop", known)
    return [each for each in demonstrations if each.name not in names]


def _refuse_contradictions(ctx: typer.Context, demonstrations: Sequence[lt.Demonstration]) -> None:
    """Refuses a recording that contradicts all others, with the command that drops it."""
    from leadthrough.models.protocol import contradicting, motions_of

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # learning warns of them again
        found = contradicting(motions_of(demonstrations))
    _refuse_named(
        ctx, {demonstrations[i].name: text for i, text in found.items()}, len(demonstrations)
    )


def _too_fast(arm: lt.Arm, motion: lt.JointTrajectory) -> str:
    """The joint that is fastest against its limit, if that is exceeded."""
    import numpy as np

    from leadthrough.noise import noise_of

    q, t = motion.positions, motion.times
    if len(t) < 2:
        return ""
    apart = min(max(1, round(_WINDOW / float(np.median(np.diff(t))))), len(t) - 1)
    spans = t[apart:] - t[:-apart]
    speeds = [np.quantile(np.abs(x[apart:] - x[:-apart]) / spans, _QUANTILE) for x in q.T]
    noise = np.array([noise_of(x[:, None]) for x in q.T])
    speeds -= _SPREAD * noise / np.median(spans)
    factors = speeds / np.where(arm.limits.velocity > 0.0, arm.limits.velocity, np.inf)
    joint = int(np.argmax(factors))
    if factors[joint] <= 1.0:
        return ""
    return (
        f"moves {arm.joint_names[joint]} at {factors[joint]:.1f} times its speed limit; check "
        "its times or --rate"
    )


def _refuse_named(ctx: typer.Context, found: Mapping[str, str], count: int) -> None:
    """Raises the error that names recordings; prints the command without them, if others stay."""
    if not found:
        return
    if len(found) < count and not ctx.params["as_json"]:
        dropped = tuple(word for name in found for word in ("--drop", name))
        output.advise(output.line(ctx, *output.repeated(ctx, changed=dropped)))
    texts = "; ".join(f"{name}: {text}" for name, text in found.items())
    names = " ".join(f"--drop {name}" for name in found)
    raise lt.errors.FitError(f"{texts}; leave out with {names}")
