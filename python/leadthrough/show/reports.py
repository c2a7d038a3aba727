"""A simulated motion as a page: the arm as it moved beside the arm as it was planned."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from leadthrough.check import Float64Array
from leadthrough.drawing import palette
from leadthrough.drawing.figure import styled
from leadthrough.io.files import StrPath, replacing
from leadthrough.show import page
from leadthrough.show.animation import ARM, Animation
from leadthrough.show.arm_scene import arm_scene
from leadthrough.simulation import SimulationReport
from leadthrough.validation import Validation

PLANNED = "planned arm"
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


_CELLS = 12  # of the map along each axis
_AXES = "xyz"


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


def success_map(validation: Validation) -> Figure:
    """The success rate over the region of goals, seen along its shortest side."""
    goals = validation.certificate.goals
    sides = goals.upper - goals.lower
    wide = sorted(np.argsort(-sides, kind="stable")[:2].tolist())
    with styled():
        figure = Figure(figsize=(5.5, 4.5))
        _draw(figure, validation, wide, sides)
    return figure


def _draw(figure: Figure, validation: Validation, wide: list[int], sides: Float64Array) -> None:
    goals, axes = validation.certificate.goals, figure.add_subplot()
    names = [_AXES[i] if len(sides) == len(_AXES) else f"coordinate {i + 1}" for i in wide]
    axes.set(xlabel=f"{names[0]} / m", ylabel=f"{names[-1]} / m")
    at = validation.goals[:, wide] if validation.goals.size else np.empty((0, len(wide)))
    known = np.isfinite(at).all(axis=1)
    if len(wide) == 2 and sides[wide].min() > 0.0:
        edges = [np.linspace(goals.lower[i], goals.upper[i], _CELLS + 1) for i in wide]
        every = _counted(at[known], edges)
        good = _counted(at[known & validation.succeeded], edges)
        rate = np.divide(good, every, out=np.full_like(every, np.nan), where=every > 0)
        drawn = axes.pcolormesh(edges[0], edges[1], rate.T, vmin=0.0, vmax=1.0, cmap="viridis")
        figure.colorbar(drawn, ax=axes, label="success rate")
    failed = at[known & ~validation.succeeded]
    if len(failed):
        axes.plot(failed[:, 0], failed[:, -1], ".", color="black", markersize=3)


def _counted(at: Float64Array, edges: list[Float64Array]) -> Float64Array:
    """The number of positions (n, 2) in each cell between the edges."""
    cells = [np.searchsorted(edge, column) - 1 for edge, column in zip(edges, at.T, strict=True)]
    counts = np.zeros((_CELLS, _CELLS))
    np.add.at(counts, tuple(np.clip(each, 0, _CELLS - 1) for each in cells), 1.0)
    return counts


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
                "goal": _listed(validation.goals[i]),
            }
            for i in failed
        ],
    }


def _listed(position: Float64Array) -> list[float] | None:
    return position.tolist() if np.isfinite(position).all() else None
