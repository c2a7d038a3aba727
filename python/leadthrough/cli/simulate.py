"""`leadthrough simulate`: what an arm makes of a motion under gravity and a controller."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadthrough.cli import chain, completion, options

if TYPE_CHECKING:
    from leadthrough.arm import Arm
    from leadthrough.simulation import Controller, Push, SimulationReport


class ControllerName(StrEnum):
    """What --controller takes."""

    COMPUTED_TORQUE = "computed-torque"
    POSITION_SERVO = "position-servo"
    JOINT_IMPEDANCE = "joint-impedance"
    CARTESIAN_IMPEDANCE = "cartesian-impedance"


def simulate(
    ctx: typer.Context,
    motion: options.MotionFile,
    robot: options.RobotName,
    limits: options.LimitsFile = None,
    base: options.BaseLink = None,
    tip: options.TipLink = None,
    mesh_folder: options.MeshFolder = None,
    obstacle: options.Obstacles = None,
    controller: Annotated[
        ControllerName, typer.Option(help="Controller that makes torques of the motion.")
    ] = ControllerName.COMPUTED_TORQUE,
    frequency: Annotated[
        float | None,
        typer.Option(help="Natural frequency of the joints' errors, in rad/s; none for the tip."),
    ] = None,
    stiffness: Annotated[
        float | None,
        typer.Option(help="Stiffness of an impedance: of the tip in N/m, of joints in N m/rad."),
    ] = None,
    skill: Annotated[
        Path | None,
        typer.Option(
            help="Skill file; cartesian-impedance is stiff where its demonstrations agree.",
            autocompletion=completion.files(".npz"),
        ),
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(help="Joint positions at which the arm rests before, as 0,-0.5,1."),
    ] = None,
    mass: Annotated[float, typer.Option(help="What the tip carries, in kg.")] = 0.0,
    payload: Annotated[
        float, typer.Option(help="Factor by which it is heavier than the controller knows.")
    ] = 1.0,
    friction: Annotated[float, typer.Option(help="Dry friction of each joint, in N m.")] = 0.0,
    damping: Annotated[float, typer.Option(help="Damping of each joint, in N m s/rad.")] = 0.0,
    delay: Annotated[float, typer.Option(help="Delay of the measurements, in s.")] = 0.0,
    encoder: Annotated[float, typer.Option(help="Steps of the encoders, in rad.")] = 0.0,
    push: Annotated[
        list[str] | None,
        typer.Option(help="Force at the tip for 0.1 s: TIME,FX,FY,FZ in s and N; may be repeated."),
    ] = None,
    tip_tolerance: Annotated[
        float | None, typer.Option(help="Largest error of the tip that is acceptable, in m.")
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(
            help="Write a page with the simulated arm beside the planned one to this HTML file.",
            autocompletion=completion.files(".html"),
        ),
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Run a joint motion on the simulated arm: torques, tracking errors, contacts (MuJoCo).

    The arm is made from its own URDF. Exits with code 1 if the motion is not fit to run.

    leadthrough simulate timed.json --robot panda --mass 1 --friction 0.2 --html simulated.html
    """
    from leadthrough.cli import errors, parse, simulated, tables
    from leadthrough.cli import robot as robots
    from leadthrough.show import simulation_page
    from leadthrough.simulation import simulate as run

    arm = robots.load(robot, limits, base, tip, mesh_folder)
    joints = robots.joints_in(arm, motion)
    if mass:
        arm = arm.with_payload(mass)
    elif payload != 1.0:
        robots.refuse("--mass", payload=payload)
    made = _controller(arm, controller.value, frequency=frequency, stiffness=stiffness, skill=skill)
    with tables.busy("simulating"), errors.naming(state="--start"):
        report = run(
            arm,
            joints,
            [parse.obstacle(text) for text in obstacle or ()],
            controller=made,
            state=None if start is None else parse.numbers(start, "--start"),
            payload=payload,
            friction=friction,
            damping=damping,
            delay=delay,
            encoder=encoder,
            pushes=[_push(text) for text in push or ()],
            tip_tolerance=tip_tolerance,
        )
    if html is not None:
        with errors.naming(path="--html", html="--html"):
            simulation_page(report, html)
    units = {"tip_error": "mm", "joint_error": "mrad", "energy": "J", "duration": "s"}
    tables.facts(simulated.facts(report, as_json=as_json), as_json=as_json, units=units)
    if not as_json:
        _hint(ctx, motion, report, html)
    if not report.ok:
        raise typer.Exit(1)


def _hint(ctx: typer.Context, motion: Path, report: SimulationReport, html: Path | None) -> None:
    kinds = {each.kind for each in report.findings}
    arm = chain.arm(ctx)
    if "contact" in kinds:
        chain.advise("plan with the obstacle, or a larger --margin, then retime and simulate")
    elif kinds & {"torque", "velocity"}:
        timed = motion.with_stem(f"{motion.stem}-timed")
        chain.hint(ctx, "leadthrough", "retime", motion, *arm, "--torques", "-o", timed)
    elif kinds:
        chain.advise("state the right --mass, raise the gains, or retime the motion more slowly")
    elif html is None:
        page = motion.with_suffix(".html")
        chain.hint(ctx, "leadthrough", "simulate", motion, *arm, "--html", page)


def _controller(
    arm: Arm,
    name: str,
    *,
    frequency: float | None,
    stiffness: float | None,
    skill: Path | None,
) -> Controller:
    """The controller that is named, with the gains that were typed."""
    from leadthrough import simulation
    from leadthrough.cli import reading
    from leadthrough.cli import robot as robots

    paced = {} if frequency is None else {"frequency": frequency}
    if name != "cartesian-impedance":
        robots.refuse("--controller cartesian-impedance", skill=skill)
    if name == "computed-torque":
        robots.refuse("another --controller", stiffness=stiffness)
        return simulation.ComputedTorque(**paced)
    if name == "position-servo":
        return simulation.PositionServo(stiffness, **paced)
    if name == "joint-impedance":
        return simulation.JointImpedance(stiffness, **paced)
    robots.refuse("another --controller", frequency=frequency)
    if skill is not None:
        robots.refuse("a --controller without --skill", stiffness=stiffness)
        return simulation.CartesianImpedance.of_skill(reading.saved_skill(skill), arm)
    return simulation.CartesianImpedance(*([] if stiffness is None else [stiffness]))


def _push(text: str) -> Push:
    from leadthrough.cli import errors, parse
    from leadthrough.errors import InvalidInput
    from leadthrough.simulation import Push

    values = parse.numbers(text, "--push")
    if len(values) != 4:
        raise InvalidInput(f"--push: expected TIME,FX,FY,FZ, got {text!r}")
    with errors.naming(time="--push", force="--push"):
        return Push(float(values[0]), values[1:])
