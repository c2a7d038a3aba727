"""The measures of all trials of the agriculture study, after figure 7 of Lauretti et al. 2023."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.drawing import palette
from leadthrough.show.plot import Style
from leadthrough_studies.agriculture.paper import BELOW_40, PRINTED, SIGNIFICANT
from leadthrough_studies.study import Row, selected

COLORS = {
    "euler": palette.AMBER,
    "log": palette.VERMILION,
    "lifted": palette.GREEN,
    "lauretti": palette.PINK,
    "anchored": palette.BLUE,
}
_PAPER: Style = {"color": "black", "linewidth": 1.0, "linestyle": ":"}
_WIDTH = 0.8  # of the columns of a task, in tasks
_ALL = "all"


def measures(config: Any, rows: list[Row], tests: list[Row]) -> Figure:
    """NPE and NOE of every trial with their means, and SR-MOD, by task and planner.

    Args:
        config: the configuration of the study.
        rows: rows of the subtasks.
        tests: rows of the tests on pairs of planners; a line joins planners whose NOE differ.
    """
    figure = Figure(figsize=(12.0, 4.2), layout="constrained")
    panels = figure.subplots(1, 3)
    for axes, column in zip(panels, ("npe", "noe"), strict=False):
        _trials(axes, config, rows, column)
    _differences(panels[1], config, tests)
    _success(panels[2], config, rows)
    panels[0].legend(fontsize=8, ncols=2, loc="upper left", markerscale=4)
    panels[2].legend(fontsize=8, loc="upper left")
    return figure


def _place(config: Any, task: int, planner: int) -> float:
    count = len(config.planners)
    return task + _WIDTH * ((planner + 0.5) / count - 0.5)


def _trials(axes: Axes, config: Any, rows: list[Row], column: str) -> None:
    rng = np.random.default_rng(0)  # for the horizontal scatter of the dots
    for i, planner in enumerate(config.planners):
        for k, task in enumerate(config.tasks):
            values = _column(rows, task, planner, column)
            x = _place(config, k, i) + rng.uniform(-0.06, 0.06, len(values))
            name = planner if k == 0 else None
            axes.plot(x, values, ".", color=COLORS[planner], markersize=3, alpha=0.6, label=name)
            if values:
                half = 0.4 * _WIDTH / len(config.planners)
                middle = _place(config, k, i)
                ends = [middle - half, middle + half]
                axes.plot(ends, [np.mean(values)] * 2, color="black", linewidth=1.5)
    axes.axhline(PRINTED["lifted"][column], **_PAPER, label="mean of the paper")
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.35)
    axes.set_xticks(range(len(config.tasks)), config.tasks, fontsize=8)
    axes.set_title(column.upper(), fontsize=10)


def _differences(axes: Axes, config: Any, tests: list[Row]) -> None:
    low, high = np.log10(axes.get_ylim())
    top = high - 0.26 * (high - low)
    for k, task in enumerate(config.tasks):
        found = [
            test["planners"].split(" and ")
            for test in selected(tests, task=task)
            if test["noe_p"] < SIGNIFICANT
        ]
        for step, pair in enumerate(found):
            ends = [_place(config, k, config.planners.index(planner)) for planner in pair]
            level = 10 ** (top + 0.04 * step * (high - low))
            axes.plot(ends, [level] * 2, color="black", linewidth=0.8)
            axes.plot(np.mean(ends), level, "*", color="black", markersize=4)
    told = f"line with a star: p < {SIGNIFICANT}, Wilcoxon, Bonferroni"
    if not any(test["noe_can_show"] for test in tests if test["task"] in config.tasks):
        told = "too few pairs in each task for any p < " + str(SIGNIFICANT)
    axes.set_xlabel(told, fontsize=8)


def _success(axes: Axes, config: Any, rows: list[Row]) -> None:
    groups = [*config.tasks, _ALL]
    for i, planner in enumerate(config.planners):
        for k, task in enumerate(groups):
            own = selected(rows, planner=planner)
            values = [row["succeeded"] for row in own if task in (_ALL, row["task"])]
            share = 100.0 * float(np.mean(values)) if values else np.nan
            place = _place(config, k, i)
            axes.bar(place, share, _WIDTH / len(config.planners), color=COLORS[planner])
            if (task, planner) in BELOW_40:
                axes.plot(place, 40.0, "v", color="black", markersize=5)
            elif task == _ALL and planner in PRINTED:
                axes.plot(place, PRINTED[planner]["sr_mod"], "_", color="black", markersize=10)
    axes.plot([], [], "_", color="black", markersize=10, label="the paper's")
    axes.plot([], [], "v", color="black", markersize=5, label="the paper's: below 40 %")
    axes.set_xticks(range(len(groups)), groups, fontsize=8)
    axes.set_ylim(0.0, 125.0)
    axes.set_yticks(range(0, 101, 20))
    axes.set_title("SR-MOD, %", fontsize=10)


def _column(rows: list[Row], task: str, planner: str, column: str) -> list[float]:
    own = selected(rows, task=task, planner=planner)
    return [row[column] for row in own if row.get(column) is not None]
