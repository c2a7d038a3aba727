"""Table and figures of the study of trajectories."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, selected
from leadthrough_studies.trajectories import generalization_figures


def report(config: Any, rows: list[Row]) -> Report:
    """The report: one line of the table per statement, and the figures."""
    nodes = selected(rows, study="runge")
    planes = selected(rows, study="phase plane")
    figures = {}
    if nodes:
        figures["runge"] = _runge_figure(nodes)
    if planes:
        figures["phase_plane"] = _plane_figure(planes)
    figures |= generalization_figures.figures(rows, config.seed)
    table = [
        *_runge_lines(nodes),
        *_lines(selected(rows, study="turning"), "way", "axis_strays_rad"),
        *_plane_lines(planes),
        *_lines(selected(rows, study="jerks"), "way", "jerk"),
        *_retimed_lines(selected(rows, study="retimed")),
        *generalization_figures.lines(rows),
    ]
    return Report(table=table, figures=figures)


def _line(study: str, what: str, measure: str, value: float) -> Row:
    return {"study": study, "what": what, "measure": measure, "value": value}


def _lines(rows: list[Row], what: str, measure: str) -> list[Row]:
    return [_line(row["study"], row[what], measure, row[measure]) for row in rows]


def _runge_lines(rows: list[Row]) -> list[Row]:
    return [
        _line("runge", f"{row['nodes']} {name} nodes", "error", row[f"{name}_error"])
        for row in rows
        for name in ("even", "chebyshev")
    ]


def _plane_lines(rows: list[Row]) -> list[Row]:
    lines = []
    for law in dict.fromkeys(row["law"] for row in rows):
        for measure in ("overshoot", "switches_in_the_last_second"):
            worst = max(row[measure] for row in selected(rows, law=law))
            lines.append(_line("phase plane", law, measure, worst))
    return lines


def _retimed_lines(rows: list[Row]) -> list[Row]:
    lines = []
    for share in dict.fromkeys(row["jerk_share"] for row in rows):
        own = selected(rows, jerk_share=share)
        what = f"{share:g} of the jerk limits"
        durations = [row["duration_s"] for row in own]
        lines.append(_line("retimed", what, "median_duration_s", float(np.median(durations))))
        kept = float(np.mean([row["kept"] for row in own]))
        lines.append(_line("retimed", what, "share_inside_all_limits", kept))
    return lines


def _runge_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(5.0, 3.5), layout="constrained")
    axes = figure.subplots()
    for name in ("even", "chebyshev"):
        axes.semilogy(
            [r["nodes"] for r in rows], [r[f"{name}_error"] for r in rows], "o-", label=name
        )
    axes.set_xlabel("nodes")
    axes.set_ylabel("largest error")
    axes.legend()
    return figure


def _plane_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(8.0, 3.5), layout="constrained")
    laws = list(dict.fromkeys(row["law"] for row in rows))
    for axes, law in zip(figure.subplots(1, len(laws), squeeze=False).ravel(), laws, strict=True):
        for row in selected(rows, law=law):
            states = np.array(row["states"])
            axes.plot(states[:, 0], states[:, 1], linewidth=1.0)
            axes.plot(0.0, 0.0, "ko", markersize=4)
        axes.set_title(law)
        axes.set_xlabel("position")
        axes.set_ylabel("velocity")
    return figure
