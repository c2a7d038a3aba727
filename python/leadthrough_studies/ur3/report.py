"""Table and figures of the workspace study."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from leadthrough.arm import Arm
from leadthrough.show import plot
from leadthrough.timing import retime
from leadthrough_studies import physics
from leadthrough_studies.demonstrator import Teaching
from leadthrough_studies.study import Report, Row, selected
from leadthrough_studies.ur3 import setups

_NOT_IN_THE_TABLE = ("study", "path", "joints")


def report(config: Any, rows: list[Row]) -> Report:
    """The experiments beside the paper's kappa; sweep and paces in figures and summary."""
    experiments, swept, taught, repeated = (
        selected(rows, study=name) for name in ("setups", "sweep", "teaching", "seeds")
    )
    figures = {}
    if experiments:
        figures["experiments"] = _scenes_figure(config, experiments)
    if swept:
        figures["sweep"] = _sweep_figure(config, swept)
    if taught:
        figures["teaching"] = _teaching_figure(taught)
    told = Report(
        table=[_without(row, *_NOT_IN_THE_TABLE) for row in experiments],
        figures=figures,
        summary={
            "assumptions": setups.__doc__,
            "teaching": [_without(row, "study") for row in taught],
            "seeds": [
                _spread(selected(repeated, setup=n)) for n in sorted({r["setup"] for r in repeated})
            ],
        },
    )
    return _with_physics(told, experiments)


def _with_physics(told: Report, experiments: list[Row]) -> Report:
    """The first experiment that the arm can run, as fast as it may, on the simulated arm."""
    for row in selected(experiments, arm_ok=1):
        arm = Arm.load("ur3")
        joints = retime(physics.joints_of(row["joints"], arm), arm.limits)
        around = setups.SETUPS[row["setup"]].around_the_arm()
        return physics.with_physics(told, arm, joints, obstacles=around)
    return told


def _spread(rows: list[Row]) -> Row:
    """Figures of one experiment with several persons: least, mean and most if they differ."""
    kappas = [row["kappa"] for row in rows]
    distances = [row["arm_distance_m"] for row in rows if row["arm_ok"]]
    return {
        "setup": rows[0]["setup"],
        "persons": len(rows),
        "kappa": [min(kappas), float(np.mean(kappas)), max(kappas)],
        "kappa_paper": rows[0]["kappa_paper"],
        "auto_learned": sum(row["auto_learned"] for row in rows),
        "arm_ok": sum(row["arm_ok"] for row in rows),
        "least_arm_distance_m": min(distances, default=None),
        "most_tip_left_path_m": max(row["tip_left_path_m"] or 0.0 for row in rows),
    }


def _without(row: Row, *columns: str) -> Row:
    return {name: value for name, value in row.items() if name not in columns}


def _scenes_figure(config: Any, rows: list[Row]) -> Figure:
    figure = Figure(figsize=(3.6 * len(rows), 4.0))
    figure.subplots_adjust(left=0.01, right=0.97, wspace=0.15)
    for i, row in enumerate(rows):
        axes: Any = figure.add_subplot(1, len(rows), i + 1, projection="3d")
        shown = setups.demonstrations(row["setup"], Teaching(), config.seed)
        for demonstration in shown:
            axes.plot(*demonstration.motion.positions.T, **plot.DEMONSTRATION)
        path = np.array(row["path"])
        axes.plot(*path.T, **plot.PATH)
        axes.scatter(*path[[0, -1]].T, color="black", s=12)
        for box in setups.SETUPS[row["setup"]].boxes():
            _draw_box(axes, box)
        axes.set_aspect("equal")
        met = "clear" if row["arm_ok"] else "not clear"
        title = f"{row['setup']}: {row['title']}\nkappa {row['kappa']:.2f}, arm: {met}"
        axes.set_title(title, fontsize=9)
        for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
            axis.set_major_locator(MaxNLocator(3))
        axes.tick_params(labelsize=6)
    return figure


def _draw_box(axes: Any, box: Any) -> None:
    corner = box.position - 0.5 * box.size
    axes.bar3d(*corner, *box.size, color="0.4", alpha=0.35)


def _sweep_figure(config: Any, rows: list[Row]) -> Figure:
    figure = Figure(figsize=(4.0 * len(config.setups), 3.4), layout="constrained")
    panels = figure.subplots(1, len(config.setups), squeeze=False).ravel()
    for axes, setup in zip(panels, config.setups, strict=True):
        for area in config.areas_of_influence:
            own = selected(rows, setup=setup, area_of_influence=area)
            saturations = [row["saturation"] for row in own]
            label = f"area of influence {100 * area:.0f} cm"
            axes.plot(saturations, [row["kappa"] for row in own], "o-", label=label)
        axes.axhline(config.threshold, color="0.5", linewidth=0.8, linestyle="--")
        axes.set_title(f"experiment {setup}")
        axes.set_xlabel("saturation")
    panels[0].set_ylabel("kappa")
    panels[0].legend(fontsize=7)
    return figure


def _teaching_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    places = np.arange(len(rows))
    for axes, column, title in (
        (left, "turning_{}_rad", "turning, rad"),
        (right, "jerk_{}", "dimensionless jerk"),
    ):
        for offset, name in ((-0.2, "shown"), (0.2, "made")):
            heights = [row[column.format(name)] for row in rows]
            axes.bar(places + offset, heights, 0.4, label=f"path {name}")
        axes.set_xticks(places, [row["pace"] for row in rows])
        axes.set_title(title)
    right.set_yscale("log")
    left.legend(fontsize=8)
    return figure
