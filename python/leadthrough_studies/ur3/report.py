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
from leadthrough_studies.ur3 import maps, setups, statements
from leadthrough_studies.ur3.statements import over_persons

_NOT_IN_THE_TABLE = ("study", "path", "joints")
_OVER_PERSONS = (
    "kappa",
    "kappa_before_rescaling",
    "kappa_with_obstacles",
    "length_m",
    "box_distance_m",
    "tip_left_path_m",
    "arm_self_distance_m",
    "quantised_end_error_m",
)
_LEFT = 1e-3  # m, beyond which the tip counts as having left its path
_EXTREMES = {
    "goal_error_m": max,
    "quantised_end_error_m": max,
    "tip_left_path_m": max,
    "arm_distance_m": min,
    "arm_self_distance_m": min,
}


def report(config: Any, rows: list[Row]) -> Report:
    """The experiments beside the paper's kappa; sweep and paces in figures and summary."""
    experiments, swept, taught, repeated = (
        selected(rows, study=name) for name in ("setups", "sweep", "teaching", "seeds")
    )
    figures = {}
    if experiments:
        figures["experiments"] = _scenes_figure(config, experiments)
    if swept:
        figures["sweep"] = _sweep_figure(config, selected(swept, seed=config.seed))
    if taught:
        figures["teaching"] = _teaching_figure(taught)
    if selected(rows, study="maps"):
        figures["figures_2_to_5"] = maps.plane_figure(config.seed)
        figures["figures_12_to_15"] = maps.dilation_figure()
    told = Report(
        table=[_without(row, *_NOT_IN_THE_TABLE) for row in experiments],
        figures=figures,
        summary={
            "assumptions": setups.__doc__,
            "teaching": [_without(row, "study") for row in taught],
        },
        tables={
            "persons": _persons(repeated),
            "sweep": _corners(config, swept),
            "maps": maps.maps_table(rows),
            **statements.tables(rows),
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


def _persons(rows: list[Row]) -> list[Row]:
    """Each experiment by either obstacle map: medians over persons, counts and extremes."""
    keys = dict.fromkeys((row["setup"], row["obstacle_map"]) for row in rows)
    return [_of_persons(selected(rows, setup=n, obstacle_map=name)) for n, name in keys]


def _of_persons(rows: list[Row]) -> Row:
    line = {name: rows[0][name] for name in ("setup", "obstacle_map", "kappa_paper")}
    line |= {"persons": len(rows)}
    line |= {name: sum(row[name] for row in rows) for name in ("auto_learned", "arm_ok")}
    line["tip_left"] = sum((row["tip_left_path_m"] or 0.0) > _LEFT for row in rows)
    for name in _OVER_PERSONS:
        line |= over_persons(rows, name)
    for name, chosen in _EXTREMES.items():
        values = [row[name] for row in rows if row[name] is not None]
        line[f"{chosen.__name__}_{name}"] = chosen(values, default=None)
    return line


def _corners(config: Any, rows: list[Row]) -> list[Row]:
    """Distance of the first experiment's paths from the demonstrations, over persons."""
    own = selected(rows, setup=1)
    keys = dict.fromkeys((row["saturation"], row["area_of_influence"]) for row in own)
    lines = []
    for saturation, area in keys:
        these = selected(own, saturation=saturation, area_of_influence=area)
        labels = {"saturation": saturation, "area_of_influence": area, "persons": len(these)}
        if len(these) == config.seeds:
            lines.append({**labels, **over_persons(these, "off_demonstrations_m")})
    return lines


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
