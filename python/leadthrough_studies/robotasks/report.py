"""Table and figures of the study of RoboTasks."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, mean, selected

ERRORS = ("mean_mm", "DTW_mm", "mean_deg", "largest_deg", "end_mm")
_DRAWN = ("DMP", "FastMarching", "nearest demonstration, shifted")


def report(config: Any, rows: list[Row]) -> Report:
    """Mean errors per task and method, and each method's place in each task by DTW distance."""
    names = list(dict.fromkeys(row["task"] for row in rows))
    table = [
        {
            "task": task,
            "method": method,
            "n": len(own),
            "refused": sum("refused" in row for row in own),
            **{error: mean(own, error) for error in ERRORS},
        }
        for task in names
        for method in config.methods
        if (own := selected(rows, task=task, method=method))
    ]
    places = {task: _places(selected(table, task=task)) for task in names}
    figures = {}
    if names:
        figures["errors"] = _errors_figure(names, table)
        figures["paths"] = _paths_figure(names, rows)
    return Report(table, figures, {"places_by_DTW": places})


def _places(table: list[Row]) -> list[str]:
    rated = [row for row in table if row["DTW_mm"] is not None]
    return [row["method"] for row in sorted(rated, key=lambda row: row["DTW_mm"])]


def _errors_figure(names: list[str], table: list[Row]) -> Figure:
    figure = Figure(figsize=(4.5 * len(names) + 2.5, 3.8), layout="constrained")
    both = figure.subplots(1, 2 * len(names), sharey=True, squeeze=False)[0]
    for i, task in enumerate(names):
        own = [row for row in selected(table, task=task) if row["refused"] < row["n"]]
        methods = [row["method"] for row in own]
        for axes, error, unit in zip(
            both[2 * i : 2 * i + 2], ("DTW_mm", "mean_deg"), ("mm", "degrees"), strict=True
        ):
            axes.barh(methods, [row[error] for row in own])
            axes.set_title(task)
            axes.set_xlabel(f"{'distance, warped' if unit == 'mm' else 'angle'}, {unit}")
    both[0].invert_yaxis()
    return figure


def _paths_figure(names: list[str], rows: list[Row]) -> Figure:
    """The first demonstration left out of each task, seen from the side."""
    figure = Figure(figsize=(4.5 * len(names), 3.8), layout="constrained")
    for axes, task in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        own = selected(rows, task=task, tested=0)
        shown = np.array(own[0]["shown"])
        axes.plot(shown[:, 0], shown[:, 2], color="0.6", linewidth=4.0, label="left out")
        made = [row for row in own if "path" in row]
        for method in _DRAWN:
            for row in selected(made, method=method):
                path = np.array(row["path"])
                axes.plot(path[:, 0], path[:, 2], label=method)
        axes.set_title(task)
        axes.set_xlabel("x, m")
        axes.set_ylabel("z, m")
        axes.set_aspect("equal")
    axes.legend(fontsize="small")
    return figure
