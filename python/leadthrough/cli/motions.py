"""`leadthrough retime` and `leadthrough guard`: joint motions within limits, and safe ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import typer

import leadthrough as lt
from leadthrough import check
from leadthrough.cli import options, output

_NO_LIMIT = "no limit"
_TIP_TOLERANCE = "1e-4,1e-3"  # m and rad
_NOISE = (1e-5, 2e-3)  # rad (m): less is rounding, more the motion's own
_ROUNDED = 1e-2  # rad (m), the tolerance of a path that is free of a hand's tremor


def retime(
    *,
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    out: options.Output,
    details: options.ArmDetails,
    rate: float = 1000.0,
    path_tolerance: float | None = None,
    tip_tolerance: str | None = None,
    keep_timing: bool = False,
    tip_speed: float | None = None,
    torques: bool = False,
    start: str | None = None,
    obstacle: options.Obstacles = None,
    format: options.FormatName = None,
    as_json: options.AsJson = False,
) -> None:
    """Run a joint motion as fast as velocity, acceleration and jerk limits allow.

    leadthrough retime motion.json --robot panda -o timed.json

    With --start, whole turns are taken the short way, and --obstacle names what the way has to
    keep clear of.

    leadthrough retime motion.csv --robot ur5.urdf --limits ur5.toml --rate 500 -o timed.script

    Options:
        rate: Sampling rate of the result, in Hz.
        path_tolerance: Largest distance of the smoothed path from the samples, in rad (m), which
            keeps a recording's noise too.
        tip_tolerance: The same at the tip and at any point of the arm, M,RAD in m and rad; by
            default 1e-4,1e-3. A recording's white noise is smoothed first, and how much is printed.
        keep_timing: Reach no point of the path earlier than it does now.
        tip_speed: Speed limit of the tip, in m/s.
        torques: Also keep within the joint torque limits.
        start: Joint positions, such as 0,-0.5,1, at which the arm rests before; a way from there
            onto the motion is written with it.
    """
    from leadthrough.cli import parse, reading, robot as robots

    reading.check_output(out, format)
    if start is None:
        robots.refuse("--start", obstacle=obstacle)
    around = parse.obstacles(obstacle)
    arm = robots.load(robot, details)
    recorded = path = robots.joints_in(arm, motion)
    noise = 0.0
    tolerance: float | lt.timing.TipTolerance
    if path_tolerance is None:
        tolerance = _at_tip(arm, tip_tolerance or _TIP_TOLERANCE)
        path, noise = _without_noise(recorded)
    else:
        robots.refuse("a path in m and rad, without --path-tolerance", tip_tolerance=tip_tolerance)
        tolerance = path_tolerance
    law = partial(
        lt.keep_timing if keep_timing else lt.retime,
        limits=arm.limits,
        rate=rate,
        path_tolerance=tolerance,
        tip_speed=None if tip_speed is None else lt.timing.TipSpeed(tip_speed, arm.jacobian),
        inverse_dynamics=arm.inverse_dynamics if torques else None,
    )
    with output.busy("timing"):
        timed = law(path)
    if start is not None:
        with output.naming(state="--start"):
            timed = law(lt.connect(parse.numbers(start, "--start"), timed, arm, around))
    limited = _limited_by(lt.timing.binding_limits(timed, arm.limits))
    reading.write_motion(timed, out, format)
    found = {
        "motion": str(out),
        "duration_before": path.duration,
        "duration": timed.duration,
        **({"smoothed": noise} if noise else {}),
        "samples": len(timed.times),
        "rate": rate,
        "limited_by": _fractions(limited),
    }
    units = {"duration_before": "s", "duration": "s", "rate": "Hz", "smoothed": "rad (m)"}
    output.facts(found, as_json=as_json, units=units)
    unbound, total = limited.get(_NO_LIMIT, 0.0), sum(limited.values())
    if (path_tolerance or 0.0) < _ROUNDED and unbound > 0.5 * total:
        output.note(
            f"for {unbound / total:.0%} of the time no limit binds: small bends of the path, "
            "such as tremor, hold the motion back; a larger --path-tolerance, up to 1e-2, rounds "
            "them"
        )
    if not as_json:
        if reading.can_read(out):
            output.hint(ctx, "check", out, *output.arm_words(ctx))
        else:
            output.advise(f"run {out} on the robot")


def _at_tip(arm: lt.Arm, text: str) -> lt.timing.TipTolerance:
    from leadthrough.cli import parse

    given = check.array(parse.numbers(text, "--tip-tolerance"), "--tip-tolerance", shape=(2,))
    position, orientation = (
        check.number(each, "--tip-tolerance", above=0.0) for each in given.tolist()
    )
    turns = [
        joint.kind != "prismatic"
        for joint in arm.robot.path(arm.base, arm.tip)
        if joint.name in arm.joint_names
    ]
    return lt.timing.TipTolerance(position, orientation, arm.levers, turns)


def _without_noise(path: lt.JointTrajectory) -> tuple[lt.JointTrajectory, float]:
    """The path without its white noise, and how strong that was, rad (m); 0 if it is not noise."""
    from leadthrough.preprocess.resample import noise_of, without_noise

    noise = noise_of(path.positions)
    if not _NOISE[0] < noise < _NOISE[1]:
        return path, 0.0
    smooth = without_noise(path.positions)
    return replace(path, positions=smooth, velocities=None, accelerations=None), noise


def _limited_by(bindings: Sequence[lt.timing.Binding]) -> dict[str, float]:
    """How long each limit binds, or none does, s."""
    lengths: dict[str, float] = {}
    for each in bindings:
        name = f"{each.joint} {each.kind}" if each.binds else _NO_LIMIT
        lengths[name] = lengths.get(name, 0.0) + each.end - each.start
    return lengths


def _fractions(limited: Mapping[str, float]) -> list[str]:
    """Binding limits and their fractions of the time, the longest first."""
    total = sum(limited.values())
    ranked = sorted(limited.items(), key=lambda item: -item[1])
    return [f"{name} {length / total:.0%}" for name, length in ranked if length > 0.005 * total]


def guard(
    *,
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    out: options.Output,
    details: options.ArmDetails,
    obstacle: options.Obstacles = None,
    margin: options.Margin = 0.005,
    rate: float | None = None,
    start: str | None = None,
    format: options.FormatName = None,
    as_json: options.AsJson = False,
) -> None:
    """Filter a joint motion: write it unchanged if safe, otherwise the nearest safe motion.

    Jumps are bridged, the motion is slowed down along its path where it exceeds a limit, and it is
    cut before a contact. The motion written ends at rest. Exits with code 1 if none of it may run;
    no file is written if no certified stop exists.

    leadthrough guard motion.json --robot panda --obstacle box:0.1,0.1,0.4@0.5,0.2,0.2 -o safe.json

    Options:
        rate: Commands per second; by default those of the motion.
        start: Joint positions, such as 0,-0.5,1, at which the arm rests; by default those of the
            first sample.
    """
    import sys

    import numpy as np

    from leadthrough.cli import parse, reading, robot as robots
    from leadthrough.guard.admission import states_of, trajectory
    from leadthrough.guard.rules import row_of

    reading.check_output(out, format)
    arm = robots.load(robot, details)
    joints = robots.joints_in(arm, motion)
    scene = lt.Scene(parse.obstacles(obstacle), margin)
    recorded = 1.0 / float(np.diff(joints.times).min(initial=1.0))
    per_second = recorded if rate is None else rate
    admits = lt.Guard(arm, scene, rate=per_second, max_samples=sys.maxsize)
    if start is not None:
        here, chunk = parse.numbers(start, "--start"), joints
    else:
        here, chunk = joints.positions[0], joints[1:] if len(joints) > 1 else joints
    with output.naming(state="--start"):
        answer = admits.admit(chunk, here)
    rest = answer.to_rest
    now = chunk.times[0] - 1.0 / per_second
    events = tuple(replace(each, time=each.time - now) for each in rest.events)
    states = np.concatenate([row_of(here, len(arm.joint_names)), states_of(rest)])
    times = np.arange(len(states)) / per_second
    written = trajectory(times, states, arm.joint_names, events)
    if answer.safe:
        reading.write_motion(written, out, format)
    found = {
        "motion": str(out) if answer.safe else "not written",
        "verdict": answer.verdict,
        "safe": answer.safe,
        "reasons": [str(each) for each in answer.reasons],
        "duration_before": joints.duration,
        "duration": written.duration,
        "rate": per_second,
    }
    units = {"duration_before": "s", "duration": "s", "rate": "Hz"}
    output.facts(found, as_json=as_json, units=units)
    if answer.safe and not as_json and reading.can_read(out):
        words = (*output.arm_words(ctx), *output.typed(ctx, "obstacle"))
        output.hint(ctx, "check", out, *words)
    if answer.verdict == "braking" or not answer.safe:
        raise typer.Exit(1)
