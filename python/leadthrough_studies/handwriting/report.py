"""The files of the handwriting demo: figures, a table of errors, joint trajectories, a page."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough import io
from leadthrough.arm import Arm, JointLimits
from leadthrough.drawing import style
from leadthrough.errors import MissingDependency
from leadthrough.io import joint_trajectory
from leadthrough.io.atomic import replacing
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.shapes import Box
from leadthrough.show import page, plot, simulation_page
from leadthrough.show.scene import Scene, arm_scene
from leadthrough.simulation import simulate
from leadthrough_studies.handwriting.demo import Handwriting, HandwritingConfig, pen
from leadthrough_studies.results import save_figure

_INTRODUCTION = (
    "People drew each of these motions seven times (LASA set). Fast Marching Learning learned six "
    "drawings and reproduced the seventh from its start. Then it planned the motion around a box. "
    "The result was placed on a table in front of a UR3 with a pen, solved for the joints, and "
    "slowed down until every joint kept its limits. Arm and pen were checked against the table, "
    "the box and each other.",
    "Drag a scene with the left mouse button to rotate it, with the right button to move it; the "
    "wheel zooms.",
)
_PEN_MASS = 0.02  # kg
_ERRORS = "Errors of the reproductions against the seventh drawing, in mm of the drawings."

COLUMNS = ("motion", "SEA_mm2", "V_rmse_mm_s", "DTWD_per_N_mm", "Frechet_mm")


@style.applied()
def write_motion(result: Handwriting, limits: JointLimits, folder: Path) -> Figure:
    """Write two figures and the joint trajectory as CSV and JSON into `folder`, made if missing.

    Returns:
        The figure of what was learned, for the page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    learning = _learning_figure(result)
    save_figure(learning, folder / "learning.png")
    save_figure(plot.joint_figure(result.joints, limits), folder / "joints.png")
    io.write_motion(result.joints, folder / "trajectory.csv")
    joint_trajectory.write_json(result.joints, folder / "trajectory.json")
    return learning


@style.applied()
def write_summary(results: Sequence[Handwriting], folder: Path) -> Figure:
    """Write a figure of all motions and the table of errors, errors.csv, into `folder`.

    Returns:
        The figure, for the page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    overview = _overview_figure(results)
    save_figure(overview, folder / "overview.png")
    with (
        replacing(folder / "errors.csv") as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(error_rows(results))
    return overview


@style.applied()
def write_page(
    results: Sequence[Handwriting],
    arm: Arm,
    config: HandwritingConfig,
    folder: Path,
    *,
    overview: Figure,
    learning: Sequence[Figure],
) -> None:
    """Write report.html: an introduction, a 3D scene of each motion, and the errors.

    Args:
        results: of the motions.
        arm: that writes.
        config: of the demo.
        folder: made if missing.
        overview: the figure of all motions.
        learning: the figure of what was learned, of each motion.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = [page.text(text) for text in _INTRODUCTION]
    parts.append(page.figure(overview, "All motions on the table."))
    for result, learned in zip(results, learning, strict=True):
        parts += _motion_parts(result, arm, config, learned)
    parts += [page.heading("Errors"), page.text(_ERRORS), page.table(COLUMNS, error_rows(results))]
    page.write_page(
        folder / "report.html", "Handwriting, learned and written by a robot arm", parts
    )


def write_simulation(result: Handwriting, arm: Arm, config: HandwritingConfig, folder: Path) -> str:
    """Write simulated.html: a motion run by the simulated arm, beside the planned one.

    Returns:
        The file and the verdict, or what to install.
    """
    try:
        found = simulate(arm.with_attached(pen(config), mass=_PEN_MASS), result.joints)
    except MissingDependency as error:
        return str(error)
    file = folder / "simulated.html"
    simulation_page(found, file, title=f"{result.name}, simulated")
    return f"{file}, {found}"


def _motion_parts(
    result: Handwriting, arm: Arm, config: HandwritingConfig, learned: Figure
) -> list[str]:
    verdict = "kept" if result.limits.ok else "exceeded"
    facts = (
        f"{result.joints.duration:.2f} s, slowed {result.slowing:.2f} times to keep the arm's "
        f"limits, which are {verdict}. Arm and pen: {result.clearance}."
    )
    return [
        page.heading(result.name),
        page.scene(_scene(result, arm, config), facts),
        page.figure(learned, "Left: the speed map. Right: the speed of the pen."),
    ]


def _scene(result: Handwriting, arm: Arm, config: HandwritingConfig) -> Scene:
    """The arm with its pen; the table is the floor, and the box is drawn above it only."""
    height = 0.5 * result.box.size[2]
    x, y, z = result.box.position
    above = Box(np.array([*result.box.size[:2], height]), np.array([x, y, z + 0.5 * height]))
    on_table = np.pad(result.detour.positions, ((0, 0), (0, 1)))
    return arm_scene(
        arm.with_attached(pen(config)),
        result.joints,
        demonstrations=[Demonstration(motion) for motion in result.shown],
        path=on_table,
        obstacles=[above],
    )


def error_rows(results: Sequence[Handwriting]) -> list[tuple[str, ...]]:
    """One row per motion and their mean, with the columns of COLUMNS."""
    values = np.array(
        [
            (e.swept_error_area, e.velocity_rmse, e.dtw_distance, e.frechet_distance)
            for e in (result.errors for result in results)
        ]
    )
    names = [*(result.name for result in results), "mean"]
    rows = np.vstack([values, values.mean(axis=0)])
    return [
        (name, *(f"{value:.4g}" for value in row)) for name, row in zip(names, rows, strict=True)
    ]


def _learning_figure(result: Handwriting) -> Figure:
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
    plot.draw_velocity_map(left, result.skill)
    _draw_motion(left, result)
    left.set_title(f"{result.name} on the table, m")
    left.legend(fontsize=7)
    _draw_speed(right, result.held_out, plot.HELD_OUT, label="held-out demonstration")
    _draw_speed(right, result.reproduction, plot.PATH, label="reproduced from its start")
    right.set_title("speed on the table, m/s")
    right.legend(fontsize=7)
    return figure


def _overview_figure(results: Sequence[Handwriting]) -> Figure:
    columns = min(len(results), 4)
    rows = -(-len(results) // columns)
    figure = Figure(figsize=(3.0 * columns, 3.0 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, result in zip(panels, results, strict=False):
        plot.draw_velocity_map(axes, result.skill)
        _draw_motion(axes, result)
        axes.set_title(result.name)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2 * min(columns, 2))
    return figure


def _draw_motion(axes: Axes, result: Handwriting) -> None:
    shown = [motion.positions for motion in result.shown]
    plot.draw_paths(axes, shown, plot.DEMONSTRATION, label="six demonstrations")
    held_out = [result.held_out.positions]
    plot.draw_paths(axes, held_out, plot.HELD_OUT, label="held-out demonstration")
    plot.draw_paths(axes, [result.reproduction.positions], plot.PATH, label="reproduction")
    plot.draw_paths(axes, [result.detour.positions], plot.DETOUR, label="around the box")
    plot.draw_box(axes, result.box)


def _draw_speed(axes: Axes, motion: Trajectory, style: plot.Style, *, label: str) -> None:
    speed = np.linalg.norm(np.gradient(motion.positions, motion.times, axis=0), axis=1)
    axes.plot(motion.times, speed, **style, label=label)
    axes.set_xlabel("time in s")
