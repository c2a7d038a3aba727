"""A simulated motion as a page: the arm as it moved beside the arm as it was planned."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from leadthrough.drawing import palette
from leadthrough.io.files import StrPath, replacing
from leadthrough.show import page
from leadthrough.show.animation import Animation, Layer
from leadthrough.show.arm_scene import arm_scene, readouts
from leadthrough.show.plot import success_map
from leadthrough.simulation import SimulationReport
from leadthrough.validation import Validation

_OPACITY = 0.3


def simulation_page(report: SimulationReport, html: StrPath, *, title: str = "") -> None:
    """Writes a page of a simulation: both arms, the verdict, figures and a table of the joints.

    Args:
        html: file to write; it needs no server and no network.
        title: of the page, by default the robot's name.

    Raises:
        InvalidInput: if the file cannot be written.
    """
    page.write_page(html, title or f"{report.arm.robot.name}, simulated", simulation_parts(report))


def simulation_parts(report: SimulationReport) -> list[str]:
    """The parts of that page, for pages that show more."""
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
    tip, _ = report.arm.forward_kinematics(report.planned.positions)
    real = arm_scene(report.arm, report.simulated, path=tip, obstacles=report.obstacles)
    plan = arm_scene(report.arm, report.planned)
    colour = palette.rgb(palette.PATH)
    first = len(real.links)
    ghosts = tuple(
        replace(each, layer=Layer.PLANNED, colour=colour, opacity=_OPACITY, link=first + each.link)
        for each in plan.items
        if each.layer == Layer.ARM and each.link is not None
    )
    return replace(
        real,
        links=(*real.links, *(f"planned {name}" for name in plan.links)),
        positions=np.concatenate([real.positions, plan.positions], axis=1),
        orientations=np.concatenate([real.orientations, plan.orientations], axis=1),
        items=(*real.items, *ghosts),
        readouts=readouts(report.arm, report.simulated, report.obstacles, tip),
    )


def write_validation(folder: Path, validation: Validation) -> None:
    """Writes report.html and results.json.

    Args:
        folder: of both files, made if missing.
        validation: by `lt.validate`.

    Raises:
        InvalidInput: if a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    certificate = validation.certificate
    with replacing(folder / "results.json") as temporary:
        temporary.write_text(json.dumps(_document(validation), indent=1) + "\n", encoding="utf-8")
    rows = [
        [cause, count, f"{count / certificate.runs:.2%}"]
        for cause, count in certificate.causes.items()
    ]
    parts = [
        page.text(f"{certificate}. Bounds by: {certificate.interval.method}. "
                  f"Seed {certificate.seed}."),
        page.text(f"Arm: {certificate.scene.robot}. Goals: {certificate.goals}. Starts: "
                  f"{certificate.starts}. {len(certificate.scene.obstacles)} obstacles."),
        page.text(_holding(validation)),
        page.figure(success_map(validation), "Success rate by the goal's position; dots: failures"),
        page.heading("Why motions failed"),
        page.table(["cause", "queries", "of all"], rows),
    ]  # fmt: skip
    if validation.nearest:
        query = (
            f"query {validation.nearest.number}, goal {validation.nearest.goal.round(4).tolist()}"
        )
        parts.append(
            page.text(f"Nearest failure to the middle: {query}. {validation.nearest.detail}")
        )
    page.write_page(folder / "report.html", "Validation", parts)


def _holding(validation: Validation) -> str:
    certificate = validation.certificate
    if certificate.holds is None:
        return f"No part of the goals has a success rate of {certificate.required:.0%} for certain."
    return (
        f"With {certificate.interval.confidence:.0%} confidence, at least "
        f"{certificate.required:.0%} of the motions to goals in {certificate.holds} succeed."
    )


def _document(validation: Validation) -> dict[str, object]:
    failed = np.flatnonzero(~validation.succeeded)
    return {
        "certificate": validation.certificate.to_settings(),
        "errors": validation.errors,
        "failures": [
            {
                "query": int(i),
                "cause": str(validation.causes[i]),
                "goal": goal.tolist() if np.isfinite(goal := validation.goals[i]).all() else None,
            }
            for i in failed
        ],
    }
