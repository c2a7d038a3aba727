"""Table and figures of the study of trajectories."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies import intervals
from leadthrough_studies.study import Report, Row, selected
from leadthrough_studies.trajectories import generalization_figures


def report(config: Any, rows: list[Row]) -> Report:
    """The report: one line of the table per statement, and the figures."""
    nodes = selected(rows, study="runge")
    planes = selected(rows, study="phase plane")
    figures = {}
    if nodes:
        figures["runge"] = _runge_figure(nodes)
    turns = selected(rows, study="turning")
    if turns:
        figures["figure_2_1"] = _turn_figure(turns)
    if planes:
        figures["figure_3_1"] = _plane_figure(planes)
    figures |= generalization_figures.figures(rows, config.seed)
    table = [
        *_runge_lines(nodes),
        *_lines(turns, "way", "axis_strays_rad"),
        *_statement_lines(rows),
        *_force_lines(selected(rows, study="forces")),
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


def _statement_lines(rows: list[Row]) -> list[Row]:
    """Lines of `interpolation`."""
    lines = [
        _line("polynomials", f"{row['nodes']} nodes", measure, row[measure])
        for row in selected(rows, study="polynomials")
        for measure in ("condition", "basis_condition", "difference", "printed_error")
    ]
    for row in selected(rows, study="freedom"):
        lines.append(_line("freedom", f"C{row['continuity']}", "left", row["left"]))
    for row in selected(rows, study="six points"):
        lines.append(_line("six points", "minimum jerk", "points", row["points"]))
        lines.append(_line("six points", "minimum jerk", "difference", row["difference"]))
    return lines


def _force_lines(rows: list[Row]) -> list[Row]:
    lines = []
    for way in dict.fromkeys(row["way"] for row in rows):
        for measure in ("force_error", "replay_error"):
            found = intervals.median([row[measure] for row in selected(rows, way=way)])
            lines += [_line("forces", way, f"{measure}_{name}", found[name]) for name in found]
    return lines


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


def _turn_figure(rows: list[Row]) -> Figure:
    """Paths of the three axes of the turned frame on the unit sphere."""
    figure = Figure(figsize=(8.0, 4.0), layout="constrained")
    around, up = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 25), np.linspace(0.0, np.pi, 13))
    sphere = np.sin(up) * np.cos(around), np.sin(up) * np.sin(around), np.cos(up)
    for i, row in enumerate(rows):
        axes: Any = figure.add_subplot(1, len(rows), i + 1, projection="3d")
        axes.plot_wireframe(*sphere, color="0.85", linewidth=0.5)
        tips = np.array(row["matrices"]).transpose(2, 1, 0)  # axis, coordinate, sample
        for (x, y, z), name, colour in zip(tips, "xyz", ("C3", "C2", "C0"), strict=True):
            axes.plot(x, y, z, color=colour, linewidth=2.0, label=f"axis {name}")
            axes.plot([0.0, x[0]], [0.0, y[0]], [0.0, z[0]], color=colour, linewidth=0.8)
        axes.set_title(row["way"])
        axes.set_box_aspect((1, 1, 1))
        axes.set_axis_off()
        axes.view_init(elev=35.0, azim=45.0)
    axes.legend(loc="lower right")
    return figure


def _plane_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(8.0, 3.5), layout="constrained")
    laws = list(dict.fromkeys(row["law"] for row in rows))
    speeds = np.linspace(-1.0, 1.0, 101)
    for axes, law in zip(figure.subplots(1, len(laws), squeeze=False).ravel(), laws, strict=True):
        axes.plot(
            -0.5 * speeds * abs(speeds), speeds, "k--", linewidth=0.8
        )  # the push changes sign here
        for row in selected(rows, law=law):
            states = np.array(row["states"])
            axes.plot(states[:, 0], states[:, 1], linewidth=1.0)
            axes.plot(*states[0], "o", color=axes.lines[-1].get_color(), markersize=3)
            axes.plot(0.0, 0.0, "ko", markersize=4)
        axes.set_title(law)
        axes.set_xlabel("position")
        axes.set_ylabel("velocity")
    return figure
