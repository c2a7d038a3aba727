"""`leadthrough plan`: a skill in, a motion out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

import leadthrough as lt
from leadthrough.cli import options, output

if TYPE_CHECKING:
    from leadthrough.motion import Motion

# Standard deviations of the demonstrated ends from which on an end is new.
_NOVEL = 3.0
# Formats that keep the joints beside a motion of the tip.
_KEEPING = ("csv", "npz")
# Options that say which motion to plan.
_ASKED = (
    *("start", "goal", "move_start", "move_goal", "duration", "dt", "obstacle"),
    *("posture", "tolerance", "free_axis", "margin", "tip_only"),
)


def plan(
    *,
    ctx: typer.Context,
    skill: options.SkillFile,
    out: options.Output,
    start: str | None = None,
    goal: str | None = None,
    move_start: str | None = None,
    move_goal: str | None = None,
    duration: float | None = None,
    dt: float = 0.01,
    obstacle: options.Obstacles = None,
    robot: options.MaybeRobotName = None,
    details: options.ArmDetails,
    posture: options.Recorded = None,
    tolerance: str | None = None,
    free_axis: list[str] | None = None,
    margin: float | None = None,
    tip_only: bool = False,
    format: options.FormatName = None,
    as_json: options.AsJson = False,
) -> None:
    """Plan a motion with a skill; with --robot, a joint motion whose tip follows it.

    The whole arm then keeps clear of obstacles, and the tip leaves its path where it has to.

    leadthrough plan pour.npz --robot panda --move-goal 0.1,0,0 -o motion.json

    leadthrough plan reach.npz --goal 0.5,0.1,0.3 --obstacle sphere:0.08@0.4,0,0.3 -o path.csv

    Options:
        start: Start: a point X,Y,Z, a pose X,Y,Z/W,X,Y,Z, or joint positions (m, rad). By default,
            and for an orientation left out, the demonstrated one.
        goal: Goal, in the form of --start.
        move_start: Offset DX,DY,DZ of the start from the demonstrated one (m, rad).
        move_goal: Offset of the goal, in the form of --move-start.
        duration: Duration, in s; by default the demonstrated one, or what the skill needs.
        dt: Time between samples, in s.
        posture: Joint positions (rad) that the arm should keep close to, or a recording of them. By
            default the demonstrated ones.
        tolerance: Error M,RAD of the tip's position and orientation that counts as reached, in m
            and rad; by default 1e-5,1e-5.
        free_axis: Axis of the tip's poses to leave free: x, y, z, or rx, ry, rz for the rotations
            about them; may be repeated. By default none, and for an arm of fewer than six joints
            those that cost the least error.
        margin: Distance that the whole arm keeps from obstacles, in m; by default 0.005.
        tip_only: Keep only the tip clear of obstacles.
    """
    from leadthrough.arm.recorded_joints import warn_of_another_arm
    from leadthrough.cli import parse, reading, robot as robots
    from leadthrough.motion import joints_with

    reading.check_output(out, format)
    learned = reading.saved_skill(skill)
    asked: dict[str, Any] = {
        "start": _end(learned, start, move_start, "start", 0),
        "goal": _end(learned, goal, move_goal, "goal", -1),
        "obstacles": parse.obstacles(obstacle) or None,
        "duration": duration,
    }
    # Unset values are left out, as a skill may not support them.
    asked = {name: value for name, value in asked.items() if value is not None}
    if robot is None:
        only = {"posture": posture, "tolerance": tolerance, "free_axis": free_axis}
        robots.refuse("--robot", **vars(details), **only)
    if robot is None or "obstacles" not in asked:
        robots.refuse("--robot and --obstacle", margin=margin, tip_only=tip_only or None)
    _warn_of_novelty(learned, asked)
    at_learning = options.of_model(getattr(learned, "model", None))
    with output.busy("planning"), output.naming(**at_learning):
        query = asked | {"dt": dt}
        facts: dict[str, Any] = {}
        arm = None
        if robot is None:
            motion: Motion = robots.generated(learned, query)
        else:
            arm = robots.load(robot, details)
            warn_of_another_arm(arm._chain, learned.generate())
            how = robots.options_of(arm, posture, tolerance, free_axis)
            if "obstacles" in asked and not tip_only:
                followed = robots.kept_clear(arm, learned, query, margin, how)
            else:
                followed = robots.followed(arm, robots.generated(learned, query), how)
            motion, facts = followed.joints, followed.facts
    _write(motion, out, format, moves_arm=robot is not None)
    if joints_with(motion) is not None and lt.io.formats.to_write(out, format).name not in _KEEPING:
        output.note(
            f"{out} does not keep the demonstrated joints, so an arm that "
            "follows it has a posture of its own; plan with --robot, or to .csv or .npz, to keep "
            "the demonstrated one"
        )
    found = {
        "motion": str(out),
        "type": type(motion).__name__,
        "duration": motion.duration,
        "start": motion.positions[0].tolist(),
        "goal": motion.positions[-1].tolist(),
        **facts,
    }
    if learned.certificate is not None:
        found["certificate"] = _certified(learned, asked, arm)
    if reason := _lengthened(learned, asked):
        found["lengthened"] = reason
    unit = "rad (m)" if hasattr(motion, "joint_names") else "m"
    units = {"duration": "s", "start": unit, "goal": unit, **robots.UNITS}
    output.facts(found, as_json=as_json, units=units)
    if not as_json:
        knows_limits = arm is None or arm.limits.acceleration is not None
        output.hint(ctx, *_next(ctx, motion, knows_limits=knows_limits))


def _next(ctx: typer.Context, motion: Motion, *, knows_limits: bool) -> tuple[str | Path, ...]:
    from leadthrough.cli import reading

    skill, out = ctx.params["skill"], ctx.params["out"]
    moves_joints = hasattr(motion, "joint_names")
    arm = output.arm_words(ctx) if ctx.params["robot"] else ("--robot", "ROBOT")
    if not moves_joints or not reading.can_read(out):  # for an arm, in a file that can be read
        again = output.typed(ctx, *_ASKED)
        if ctx.params["robot"] or not moves_joints:
            again += arm
        return ("plan", skill, *again, "-o", out.with_suffix(".json"))
    timed = out.with_stem(f"{out.stem}-timed")
    if knows_limits:
        return ("retime", out, *arm, "-o", timed)
    return _limits_first(ctx, ("retime", out), ("-o", timed))


def _limits_first(
    ctx: typer.Context, begin: tuple[str | Path, ...], end: tuple[str | Path, ...]
) -> tuple[str | Path, ...]:
    """A command line behind one that writes the limits that the robot's description lacks."""
    from leadthrough.cli import robot as robots

    urdf = robots.urdf_of(ctx.params["robot"])
    target = Path(f"{urdf.stem}.toml")
    target = target.with_stem(f"{urdf.stem}-limits") if target.exists() else target
    known = output.typed(ctx, "base", "tip", "limits", "mesh_folder")
    arm = output.typed(ctx, "robot", "base", "tip", "mesh_folder")
    written: tuple[str | Path, ...]
    written = ("info", urdf, *known, "--write-limits", target)
    return (*written, "&&", *begin, *arm, "--limits", target, *end)


def _write(motion: Motion, out: Path, format: str | None, *, moves_arm: bool) -> None:
    from leadthrough.cli import reading

    try:
        reading.write_motion(motion, out, format)
    except lt.errors.InvalidInput as error:
        if moves_arm or isinstance(motion, lt.JointTrajectory):
            raise
        raise lt.errors.InvalidInput(f"{error}; with --robot, plan writes joints") from None


def _end(
    learned: lt.models.Skill, given: str | None, moved: str | None, name: str, index: int
) -> lt.models.Target | None:
    from leadthrough.cli import parse

    if given is not None and moved is not None:
        raise lt.errors.InvalidInput(f"--{name}: use --{name} or --move-{name}, got both")
    if given is not None:
        return parse.end(given, learned.generate(), index, f"--{name}")
    if moved is not None:
        return parse.moved(moved, learned.generate(), index, f"--move-{name}")
    return None


def _warn_of_novelty(learned: lt.models.Skill, asked: dict[str, Any]) -> None:
    """Warns on stderr of an end far from the demonstrated ones."""
    novelty = getattr(learned, "novelty", None)
    if novelty is None:
        return
    ends: list[str] = [name for name in ("start", "goal") if name in asked]
    far: dict[str, float] = {name: novelty(**{name: asked[name]}) for name in ends}
    # Either may be usual by itself, and not both at once.
    if len(ends) == 2 and max(far.values()) < _NOVEL:
        far = {"start and goal together": novelty(**{name: asked[name] for name in ends})}
    for name, deviations in far.items():
        if deviations >= _NOVEL:
            output.warn(
                f"{name}: {deviations:.3g} standard deviations from what was "
                "demonstrated, so the motion is extrapolated there; check it before an arm moves, "
                "choose a nearer one or add a demonstration of it"
            )


def _certified(learned: lt.models.Skill, asked: dict[str, Any], arm: lt.Arm | None) -> str:
    """Whether the query is one of those that the skill's certificate speaks of."""
    from leadthrough.validation.validate import name_of

    certificate = learned.certificate
    assert certificate is not None  # asked before
    motion = learned.generate()
    ends = {}
    for name, index in (("start", 0), ("goal", -1)):
        place: lt.models.Target = motion.positions[index]
        if isinstance(motion, lt.PoseTrajectory):
            place = (motion.positions[index], motion.orientations[index])
        ends[name] = asked.get(name, place)
    reasons = certificate.outside(
        **ends, obstacles=asked.get("obstacles", ()), robot=name_of(arm) if arm else ""
    )
    if reasons:
        return f"outside: {'; '.join(reasons)}"
    interval = certificate.interval
    bounds = f"{interval.lower:.1%} to {interval.upper:.1%}"
    return f"inside: {bounds} of {certificate.runs} such queries succeed"


def _lengthened(learned: lt.models.Skill, asked: dict[str, Any]) -> str | None:
    """Why a primitive takes longer than demonstrated, if it does."""

    if not isinstance(learned, lt.models.DMPSkill) or "duration" in asked:
        return None
    ends = {name: asked[name] for name in ("start", "goal") if name in asked}
    needed = learned.default_duration(**ends)
    if needed == learned.duration:
        return None
    return (
        f"from {learned.duration:.4g} to {needed:.4g} s, so that the moved start or goal does not "
        "make the motion more than 1.3 times as fast as demonstrated; --duration sets another"
    )
