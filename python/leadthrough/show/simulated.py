"""A simulated motion as a page: the arm as it moved beside the arm as it was planned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough.drawing import palette
from leadthrough.io.atomic import StrPath
from leadthrough.show import page
from leadthrough.show.scene import ARM, Animation, arm_scene
from leadthrough.simulation import SimulationReport

PLANNED = "planned arm"
_OPACITY = 0.3


def simulation_page(report: SimulationReport, html: StrPath, *, title: str = "") -> None:
    """Writes a page of a simulation: both arms, the verdict, figures and a table of the joints.

    Args:
        report: of `lt.simulate`.
        html: file to write; it needs no server and no network.
        title: of the page, by default the robot's name.

    Raises:
        InvalidInput: if the file cannot be written.
    """
    page.write_page(html, title or f"{report.arm.robot.name}, simulated", simulation_parts(report))


def simulation_parts(report: SimulationReport) -> list[str]:
    """The parts of that page, for pages that show more.

    Args:
        report: of `lt.simulate`.
    """
    return [
        page.scene(simulation_scene(report), "The arm as simulated; transparent, as planned."),
        page.text(str(report)),
        page.figure(report.plot(), "Dotted: beginning and end of the motion that was given."),
        page.table(*joint_table(report)),
    ]


def joint_table(report: SimulationReport) -> tuple[list[str], list[list[str]]]:
    """Names of the columns, and a row for each joint."""
    errors = ["error, mrad (mm)", "allowed"]
    columns = ["joint", *errors, "torque, N m (N)", "of the limit", "energy, J"]
    rows = zip(
        report.arm.joint_names,
        1e3 * np.abs(report.errors).max(axis=0),
        1e3 * report.allowed,
        np.abs(report.torques).max(axis=0),
        report.torque_fractions,
        report.energy,
        strict=True,
    )
    return columns, [
        [name, f"{far:.3g}", f"{most:.3g}", f"{torque:.3g}", f"{part:.0%}", f"{energy:.3g}"]
        for name, far, most, torque, part, energy in rows
    ]


def simulation_scene(report: SimulationReport) -> Animation:
    """The simulated arm and the planned one in one scene."""
    tip, _ = report.arm.forward_kinematics(report.planned.positions)
    real = arm_scene(report.arm, report.simulated, path=tip, obstacles=report.obstacles)
    plan = arm_scene(report.arm, report.planned)
    colour = palette.rgb(palette.PATH)
    first = len(real.links)
    ghosts = tuple(
        replace(each, layer=PLANNED, colour=colour, opacity=_OPACITY, link=first + each.link)
        for each in plan.items
        if each.layer == ARM and each.link is not None
    )
    return replace(
        real,
        links=(*real.links, *(f"planned {name}" for name in plan.links)),
        positions=np.concatenate([real.positions, plan.positions], axis=1),
        orientations=np.concatenate([real.orientations, plan.orientations], axis=1),
        items=(*real.items, *ghosts),
    )
