"""Commands on joint motions: `leadthrough retime`, `check`, `guard` and `simulate`."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import partial
from pathlib import Path

import typer

import leadthrough as lt
from leadthrough.cli import options, output

_NO_LIMIT = "no limit"
_MAX_THREADS = 8  # of a check of collisions
_TIP_TOLERANCE = "1e-4,1e-3"  # m and rad
_NOISE = (1e-7, 2e-3)  # rad (m): less is rounding, more the motion's own
_ROUNDED = 1e-2  # rad (m), the tolerance of a path that is free of a hand's tremor
_TORQUE_USED = 0.9  # of the limits with --torques


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

    With --start, joints take the shorter of two directions around, and the approach from there
    avoids --obstacle.

    leadthrough retime motion.csv --robot ur5.urdf --limits ur5.toml --rate 500 -o timed.script

    Options:
        rate: Sampling rate of the result, in Hz.
        path_tolerance: Largest distance of the smoothed path from the samples, in rad (m), which
            keeps a recording's noise too.
        tip_tolerance: The same at the tip and at any point of the arm, M,RAD in m and rad; by
            default 1e-4,1e-3. A recording's white noise is smoothed first, and how much is printed.
        keep_timing: Reach no point of the path earlier than it does now.
        tip_speed: Speed limit of the tip, in m/s.
        torques: Also keep within 90 % of the joint torque limits, with the URDF's friction; what
            is left is for the controller, which has to bear what the model does not know.
        start: Joint positions, such as 0,-0.5,1, at which the arm rests before; an approach from
            there onto the motion is written with it.
    """
    from leadthrough.cli import parse, reading, robot as robots

    reading.check_output(out, format)
    if start is None:
        robots.refuse("--start", obstacle=obstacle)
    around = parse.obstacles(obstacle)
    arm = robots.load(robot, details)
    path = robots.joints_in(arm, motion)
    noise = 0.0
    tolerance: float | lt.timing.TipTolerance
    if path_tolerance is None:
        tolerance = _at_tip(arm, tip_tolerance or _TIP_TOLERANCE)
        path, noise = _without_noise(path)
    else:
        robots.refuse("a path in m and rad, without --path-tolerance", tip_tolerance=tip_tolerance)
        tolerance = path_tolerance
    limits = _with_torque_reserve(arm.limits) if torques else arm.limits
    dynamics = arm.motor_torques if torques else None
    law = partial(
        lt.keep_timing if keep_timing else lt.retime,
        limits=limits,
        rate=rate,
        path_tolerance=tolerance,
        tip_speed=None if tip_speed is None else lt.timing.TipSpeed(tip_speed, arm.jacobian),
        inverse_dynamics=dynamics,
    )
    with output.busy("timing"):
        timed = law(path)
    if start is not None:
        with output.naming(state="--start"):
            timed = law(lt.connect(parse.numbers(start, "--start"), timed, arm, around))
    limited = _limited_by(lt.timing.binding_limits(timed, limits, inverse_dynamics=dynamics))
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
    if not torques and (path_tolerance or 0.0) < _ROUNDED and unbound > 0.5 * total:
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


def _with_torque_reserve(limits: lt.arm.JointLimits) -> lt.arm.JointLimits:
    effort = limits.effort
    return limits if effort is None else replace(limits, effort=_TORQUE_USED * effort)


def _at_tip(arm: lt.Arm, text: str) -> lt.timing.TipTolerance:
    from leadthrough.cli import parse

    position, orientation = parse.tolerances(text, "--tip-tolerance")
    turns = [
        joint.kind != "prismatic"
        for joint in arm.robot.path(arm.base, arm.tip)
        if joint.name in arm.joint_names
    ]
    return lt.timing.TipTolerance(position, orientation, arm.levers, turns)


def _without_noise(path: lt.JointTrajectory) -> tuple[lt.JointTrajectory, float]:
    """The path without its white noise, and how strong that was, rad (m); 0 if it is not noise."""
    from leadthrough.noise import noise_of, without_noise

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
    torques: bool = False,
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
        torques: Also keep within the joint torque limits.
        start: Joint positions, such as 0,-0.5,1, at which the arm rests; by default those of the
            first sample.
    """

    import numpy as np

    from leadthrough.cli import parse, reading, robot as robots
    from leadthrough.guard.admission import begun_at

    reading.check_output(out, format)
    arm = robots.load(robot, details)
    joints = robots.joints_in(arm, motion)
    scene = lt.Scene(parse.obstacles(obstacle), margin)
    recorded = 1.0 / float(np.diff(joints.times).min(initial=1.0))
    per_second = recorded if rate is None else rate
    dynamics = arm.motor_torques if torques else None
    admits = lt.Guard(
        arm, scene, rate=per_second, max_samples=sys.maxsize, inverse_dynamics=dynamics
    )
    if start is not None:
        here, chunk = parse.numbers(start, "--start"), joints
    else:
        here, chunk = joints.positions[0], joints[1:] if len(joints) > 1 else joints
    with output.naming(state="--start"):
        answer = admits.admit(chunk, here)
    duration = joints.duration
    # Of a long log, each is as large as the log.
    del admits, joints, chunk
    rest, answer = answer.to_rest, replace(answer, motion=answer.brake)
    written = begun_at(rest, np.asarray(here), per_second)
    del rest
    if answer.safe:
        reading.write_motion(written, out, format)
    found = {
        "motion": str(out) if answer.safe else "not written",
        "verdict": answer.verdict,
        "safe": answer.safe,
        "reasons": [str(each) for each in answer.reasons],
        "duration_before": duration,
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


def check(
    *,
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    details: options.ArmDetails,
    obstacle: options.Obstacles = None,
    margin: options.Margin = 0.005,
    rate: float | None = None,
    physics: bool = False,
    as_json: options.AsJson = False,
) -> None:
    """Check a joint motion against the arm's limits and for collisions, also with itself.

    Exits with code 1 if a limit is exceeded, there is a collision, or the simulated arm fails.

    leadthrough check timed.json --robot panda --obstacle box:0.1,0.1,0.4@0.5,0.2,0.2

    Options:
        rate: Rate in Hz of a receiver that runs the positions alone, straight from one to the next;
            by default so are files without velocities and accelerations, at their own.
        physics: Also simulate it under gravity; `leadthrough simulate` reports more.
    """
    from leadthrough.cli import parse, robot as robots

    arm = robots.load(robot, details)
    joints = robots.joints_in(arm, motion)
    scene = lt.Scene(parse.obstacles(obstacle), margin)
    with output.naming(linear_rate="--rate"):
        verdict = lt.check_limits(joints, arm.limits, linear_rate=_linear_rate(joints, rate))
    with output.busy("checking"):
        clearance = _clearance(arm, joints, scene)
    clear = clearance is None or clearance.ok
    simulated = None
    if physics:
        with output.busy("simulating"):
            simulated = lt.simulate(arm, joints, scene)
    quantities = ("position", "velocity", "acceleration", "jerk")
    found = {
        "ok": verdict.ok and clear and (simulated is None or simulated.ok),
        "limits_kept": verdict.ok,
        **{f"{name}_used": _peak(getattr(verdict, name), as_json) for name in quantities},
        **_clearance_facts(clearance, as_json),
        "duration": joints.duration,
    }
    if simulated is not None:
        stated = _simulation_facts(simulated, as_json=True) if as_json else str(simulated)
        found["simulated"] = stated
    output.facts(found, as_json=as_json, units={"duration": "s"})
    if not as_json:
        fails = simulated is not None and not simulated.ok
        _hint_after_check(ctx, motion, limits_kept=verdict.ok, clear=clear, fails=fails)
    if not found["ok"]:
        raise typer.Exit(1)


def _clearance(
    arm: lt.Arm, joints: lt.JointTrajectory, scene: lt.Scene
) -> lt.arm.CollisionReport | None:
    """The report on collisions; None, with a warning, if neither arm nor scene has a shape."""
    if scene.obstacles or arm.attached or arm._robot.collisions:
        return arm.check(joints, scene, threads=min(os.cpu_count() or 1, _MAX_THREADS))
    output.warn(
        "--robot: no link has collision geometry, so the limits are checked and collisions are not"
    )
    return None


def _clearance_facts(clearance: lt.arm.CollisionReport | None, as_json: bool) -> dict[str, object]:
    if clearance is None:
        return {"clear": None if as_json else "not checked, no link has collision geometry"}
    return {
        "clear": clearance.ok,
        "nearest_obstacle": _approach(clearance.obstacles, as_json),
        "nearest_itself": _approach(clearance.itself, as_json),
    }


def _linear_rate(joints: lt.JointTrajectory, rate: float | None) -> float | None:
    """The rate of a receiver of positions; None if it reads velocities and accelerations too."""
    whole = joints.velocities is not None and joints.accelerations is not None
    steps = len(joints.times) - 1
    if rate is not None or whole or not steps:
        return rate
    return steps / joints.duration


def _hint_after_check(
    ctx: typer.Context, motion: Path, *, limits_kept: bool, clear: bool, fails: bool
) -> None:
    arm, around = output.arm_words(ctx), output.typed(ctx, "obstacle")
    if not clear:
        output.advise("replan with a larger --margin or another --posture, then retime and check")
    elif not limits_kept:
        timed = motion.with_stem(f"{motion.stem}-timed")
        output.hint(ctx, "retime", motion, *arm, "-o", timed)
    elif fails:
        output.hint(ctx, "simulate", motion, *arm, *around)
    else:
        output.hint(ctx, "view", motion, *arm, *around, "--html", motion.with_suffix(".html"))


def _peak(peak: lt.timing.Peak | None, as_json: bool) -> object:
    if as_json:
        return peak and {"ratio": peak.ratio, "joint": peak.joint, "time": peak.time}
    return "not checked, the limit is not known" if peak is None else str(peak)


def _approach(clearance: lt.arm.Clearance, as_json: bool) -> object:
    nearest = clearance.closest
    if as_json:
        return nearest and {
            "distance": nearest.distance,
            "bodies": nearest.bodies,
            "time": nearest.time,
        }
    return "nothing to collide with" if nearest is None else str(nearest)


class ControllerName(StrEnum):
    COMPUTED_TORQUE = "computed-torque"
    POSITION_SERVO = "position-servo"
    JOINT_IMPEDANCE = "joint-impedance"
    CARTESIAN_IMPEDANCE = "cartesian-impedance"


def simulate(
    *,
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    details: options.ArmDetails,
    obstacle: options.Obstacles = None,
    controller: ControllerName = ControllerName.COMPUTED_TORQUE,
    frequency: float | None = None,
    stiffness: float | None = None,
    skill: options.SkillPath = None,
    start: str | None = None,
    mass: float = 0.0,
    density: float | None = None,
    ideal: bool = False,
    payload: float | None = None,
    friction: float | None = None,
    damping: float | None = None,
    delay: float | None = None,
    encoder: float | None = None,
    rotor_inertia: float | None = None,
    push: list[str] | None = None,
    margin: options.Margin = 0.005,
    tip_tolerance: float | None = None,
    html: options.PagePath = None,
    as_json: options.AsJson = False,
) -> None:
    """Run a joint motion on the simulated arm: torques, tracking errors, contacts (MuJoCo).

    The arm is made from its own URDF, with rotors, friction, encoders and a delay of real arms, and
    a payload that is known to 5 %. Exits with code 1 if the motion is not fit to run.

    leadthrough simulate timed.json --robot panda --mass 1 --html simulated.html

    Options:
        controller: Controller that makes torques of the motion.
        frequency: Natural frequency of the joints' errors, in rad/s; none for the tip.
        stiffness: Stiffness of an impedance: of the tip in N/m, of joints in N m/rad.
        skill: Skill file; cartesian-impedance is stiff where its demonstrations agree.
        start: Joint positions at which the arm rests before, as 0,-0.5,1.
        mass: Mass that the tip carries, in kg.
        density: Density of links whose URDF states no mass, in kg/m^3; 1000 is that of water.
        ideal: An arm without rotors, friction, delay and encoder steps, its payload known exactly.
        payload: Factor by which it is heavier than the controller knows; by default 1.05.
        friction: Dry friction of each joint, in N m; by default that of a real arm.
        damping: Damping of each joint, in N m s/rad; by default that of a real arm.
        delay: Delay of the measurements, in s; by default one period.
        encoder: Steps of the encoders, in rad; by default those of a real arm.
        rotor_inertia: Inertia of each motor behind its gear, in kg m^2; by default a real one's.
        push: Force at the tip for 0.1 s: TIME,FX,FY,FZ in s and N; may be repeated.
        tip_tolerance: Largest error of the tip that is acceptable, in m.
        html: Write a page with the simulated arm beside the planned one to this HTML file.
    """
    from leadthrough.cli import parse, robot as robots

    arm = robots.load(robot, details)
    if density is not None:
        arm = arm.with_density(density)
    if mass:
        arm = arm.with_payload(mass)
    elif payload not in (None, 1.0):
        robots.refuse("--mass", payload=payload)
    made = _controller(arm, controller.value, frequency=frequency, stiffness=stiffness, skill=skill)
    with output.busy("simulating"), output.naming(state="--start"):
        report = lt.simulate(
            arm,
            robots.joints_in(arm, motion),
            lt.Scene(parse.obstacles(obstacle), margin),
            controller=made,
            state=None if start is None else parse.numbers(start, "--start"),
            disturbances=_disturbances(
                ideal,
                [_push(text) for text in push or ()],
                payload=payload,
                friction=friction,
                damping=damping,
                delay=delay,
                encoder=encoder,
                rotor_inertia=rotor_inertia,
            ),
            tip_tolerance=tip_tolerance,
        )
    if html is not None:
        with output.naming(path="--html", html="--html"):
            lt.show.simulation_page(report, html)
    units = {"tip_error": "mm", "joint_error": "mrad", "energy": "J", "duration": "s"}
    output.facts(_simulation_facts(report, as_json=as_json), as_json=as_json, units=units)
    if not as_json:
        _hint_after_simulation(ctx, motion, report, html)
    if not report.ok:
        raise typer.Exit(1)


def _disturbances(
    ideal: bool, pushes: list[lt.simulation.Push], **given: float | None
) -> lt.simulation.Disturbances:
    """The disturbances that were typed, and otherwise those of a real arm, or none."""
    kind = lt.simulation.Disturbances
    others = {name: value for name, value in given.items() if value is not None}
    return replace(kind.ideal() if ideal else kind(), pushes=pushes, **others)


def _hint_after_simulation(
    ctx: typer.Context, motion: Path, report: lt.SimulationReport, html: Path | None
) -> None:
    kinds = {each.kind for each in report.findings}
    arm = output.arm_words(ctx)
    if "contact" in kinds:
        output.advise("plan with the obstacle, or a larger --margin, then retime and simulate")
    elif kinds & {"torque", "velocity"}:
        timed = motion.with_stem(f"{motion.stem}-timed")
        output.hint(ctx, "retime", motion, *arm, "--torques", "-o", timed)
    elif "margin" in kinds:
        output.advise("plan with a larger --margin, raise the gains, or retime it more slowly")
    elif kinds:
        output.advise("state the right --mass, raise the gains, or retime the motion more slowly")
    elif html is None:
        output.hint(ctx, "simulate", motion, *arm, "--html", motion.with_suffix(".html"))


def _controller(
    arm: lt.Arm,
    name: str,
    *,
    frequency: float | None,
    stiffness: float | None,
    skill: Path | None,
) -> lt.simulation.Controller:
    """The controller that is named, with the gains that were typed."""
    from leadthrough.cli import reading, robot as robots

    paced = {} if frequency is None else {"frequency": frequency}
    if name != "cartesian-impedance":
        robots.refuse("--controller cartesian-impedance", skill=skill)
    if name == "computed-torque":
        robots.refuse("another --controller", stiffness=stiffness)
        return lt.simulation.ComputedTorque(**paced)
    if name == "position-servo":
        return lt.simulation.PositionServo(stiffness, **paced)
    if name == "joint-impedance":
        return lt.simulation.JointImpedance(stiffness, **paced)
    robots.refuse("another --controller", frequency=frequency)
    if skill is not None:
        robots.refuse("a --controller without --skill", stiffness=stiffness)
        return lt.simulation.CartesianImpedance.of_skill(reading.saved_skill(skill), arm)
    return lt.simulation.CartesianImpedance(*([] if stiffness is None else [stiffness]))


def _push(text: str) -> lt.simulation.Push:
    from leadthrough.cli import parse

    values = parse.numbers(text, "--push")
    if len(values) != 4:
        raise lt.errors.InvalidInput(f"--push: expected TIME,FX,FY,FZ, got {text!r}")
    with output.naming(time="--push", force="--push"):
        return lt.simulation.Push(float(values[0]), values[1:])


def _simulation_facts(report: lt.SimulationReport, *, as_json: bool) -> dict[str, object]:
    joint = int(report.torque_fractions.argmax())
    worst = int(abs(report.errors).max(axis=0).argmax())
    name, fraction = report.arm.joint_names[joint], float(report.torque_fractions[joint])
    tip, turn = float(report.tip_errors.max()), float(abs(report.errors[:, worst]).max())
    return {
        "fit_to_run": report.ok,
        "findings": [str(each) for each in report.findings],
        "tip_error": tip if as_json else 1e3 * tip,
        "joint_error": turn if as_json else 1e3 * turn,
        "torque_used": {"ratio": fraction, "joint": name} if as_json else f"{fraction:.0%}, {name}",
        "contacts": [str(each) for each in report.contacts],
        "energy": float(report.energy.sum()),
        "duration": report.planned.duration,
    }
