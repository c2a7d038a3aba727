"""What the handwriting demo writes: figures, a table of errors, joint trajectories."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.drawing import palette
from leadthrough.drawing.figure import styled
from leadthrough.io.files import replacing
from leadthrough.motion import Trajectory
from leadthrough.show import page, plot
from leadthrough_studies.handwriting.demo import Handwriting
from leadthrough_studies.results import save_figure

MEASURES = {
    "SEA": "Swept error area, mm²: the area between the reproduction and the drawing.",
    "V_rmse": "Root mean square of the difference between both velocities at the same times, mm/s.",
    "DTWD/N": "Distance under dynamic time warping per sample, mm: how far the paths are apart, "
    "whatever their timing.",
    "Fréchet": "Fréchet distance, mm: the farthest that the paths are apart, passed in step.",
}
LEGEND = {
    "six demonstrations": palette.DEMONSTRATION,
    "held-out demonstration": palette.BLACK,
    "reproduction": palette.PATH,
    "around the box": palette.DETOUR,
}
DASHED = ("held-out demonstration",)

COLUMNS = ("motion", "SEA_mm2", "V_rmse_mm_s", "DTWD_per_N_mm", "Frechet_mm")


@styled()
def write_learning(result: Handwriting, folder: Path) -> None:
    """Write the figure of what was learned, learning.png, into `folder`."""
    save_figure(_learning_figure(result), folder / "learning.png")


@styled()
def write_summary(results: Sequence[Handwriting], folder: Path) -> None:
    """Write a figure of all motions and the table of errors, errors.csv, into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(_overview_figure(results), folder / "overview.png")
    with (
        replacing(folder / "errors.csv") as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(error_rows(results))


@styled()
def maps(results: Sequence[Handwriting]) -> list[str]:
    """A figure of each motion on the table, for a page; `LEGEND` says what its lines are.

    Args:
        results: of the motions.
    """
    figures = []
    for result in results:
        drawn = Figure(figsize=(3.0, 3.0), layout="constrained")
        axes = drawn.subplots()
        axes.set_axis_off()
        _draw_map(axes, result)
        figures.append(page.figure(drawn, result.name))
    return figures


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
        (name, *(f"{value:.3g}" for value in row)) for name, row in zip(names, rows, strict=True)
    ]


def _learning_figure(result: Handwriting) -> Figure:
    figure = Figure(figsize=(10.0, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
    _draw_map(left, result)
    left.set_title(f"{result.name} on the table, m")
    _draw_speed(right, result.held_out, plot.HELD_OUT)
    _draw_speed(right, result.reproduction, plot.PATH)
    right.set_title("speed on the table, m/s")
    _add_legend(figure, left)
    return figure


def _overview_figure(results: Sequence[Handwriting]) -> Figure:
    columns = min(len(results), 4)
    rows = -(-len(results) // columns)
    figure = Figure(figsize=(3.0 * columns, 3.0 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, result in zip(panels, results, strict=False):
        _draw_map(axes, result)
        axes.set_title(result.name)
    _add_legend(figure, panels[0], columns=2 * min(columns, 2))
    return figure


def _add_legend(figure: Figure, axes: Axes, *, columns: int = 4) -> None:
    """A legend below all axes, clear of the curves."""
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns)


def _draw_map(axes: Axes, result: Handwriting) -> None:
    """The speed map, the drawings and the box."""
    demonstrations, held_out, reproduction, detour = LEGEND
    plot.draw_velocity_map(axes, result.skill)
    shown = [motion.positions for motion in result.shown]
    plot.draw_paths(axes, shown, plot.DEMONSTRATION, label=demonstrations)
    plot.draw_paths(axes, [result.held_out.positions], plot.HELD_OUT, label=held_out)
    plot.draw_paths(axes, [result.reproduction.positions], plot.PATH, label=reproduction)
    plot.draw_paths(axes, [result.detour.positions], plot.DETOUR, label=detour)
    plot.draw_box(axes, result.box)


def _draw_speed(axes: Axes, motion: Trajectory, style: plot.Style) -> None:
    speed = np.linalg.norm(np.gradient(motion.positions, motion.times, axis=0), axis=1)
    axes.plot(motion.times, speed, **style)
    axes.set_xlabel("time in s")
