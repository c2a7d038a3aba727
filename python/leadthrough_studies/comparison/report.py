"""Table, figures and remarks of the comparison."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough.io import lasa
from leadthrough.show import plot
from leadthrough_studies.comparison.figures import (
    decisions,
    one_and_many_shots,
    stability,
    without_and_with_experience,
)
from leadthrough_studies.comparison.on_arms import ARMS
from leadthrough_studies.comparison.pages import page_parts
from leadthrough_studies.comparison.paper import PIXELS_PER_MM, REMARK, TABLE_1, TABLE_2
from leadthrough_studies.comparison.recordings import ERRORS, relative
from leadthrough_studies.comparison.rivals import AT_ITS_BEST, LIBRARIES, MISSING
from leadthrough_studies.study import Report, Row, mean, selected

_RESPONSES = ("goal_Frechet_mm", "goal_end_mm")
_PUSHES = (
    "push_Frechet_mm",
    "push_any_fade_mm",
    "held_Frechet_mm",
    "push_at_25_mm",
    "push_at_50_mm",
    "push_at_75_mm",
)
_PUSHES_OF_THE_ARM = ("displaced_mm", *(name for name in _PUSHES if name != "held_Frechet_mm"))
_COSTS = ("fit_cpu_s", "generate_cpu_s")
_ON_ARM = ("executed", "reachable", "without_leap", "clear", "slower", "begins_at")
_ON_ARMS = tuple(f"{arm}_{name}" for arm in ARMS for name in _ON_ARM)
_SHARED = (*_RESPONSES, *_COSTS, *_ON_ARMS)
_DRAWING = (
    "SEA_mm2",
    "V_rmse_mm_s",
    "DTW_mm",
    "Frechet_mm",
    "end_mm",
    "direction_error",
    "direction_error_smoothed",
    *_SHARED,
)
_COURSE = ("V_rmse_mm_s", "DTW_mm", "Frechet_mm", "end_mm", *_SHARED)
_POSE = (
    "mean_mm",
    "V_rmse_mm_s",
    "DTW_mm",
    "Frechet_mm",
    "mean_deg",
    "end_mm",
    "end_deg",
    *_SHARED,
)
# Methods to whose errors those of all are relative on sets of recordings.
_REFERENCES = ("FastMarching", AT_ITS_BEST)
_PICTURED = ("FastMarching", "ProMP", "CLF-DM", "Modified DS", "SEDS, likelihood")


def report(config: Any, rows: list[Row]) -> Report:
    """The means of every method by protocol and task, and the paper's tables anew."""
    if config.recordings:
        return _of_recordings(config, rows)
    table = [*_drawings(config, rows), *_others(config, rows)]
    figures = {"errors": _errors_figure(config, rows)} if selected(rows, study="drawings") else {}
    for start in range(0, len(config.motions), 15):
        motions = config.motions[start : start + 15]
        figures[f"paths_{start // 15 + 1}"] = _paths_figure(motions, rows)
    if config.motions:
        figures |= {
            "figure_16": without_and_with_experience(config.motions[0]),
            "figure_17": one_and_many_shots(config.motions[0]),
            "figure_18": decisions(config.motions[0]),
        }
    systems = [name for name in config.points if selected(rows, study="stability", method=name)]
    if systems:
        figures["stability"] = stability(config.motions[-1], systems)
    summary = {
        "remark": REMARK,
        "first": _first(table),
        "not_installed": list(MISSING),
        "rivals": {name: version(name) for name in LIBRARIES.values() if name not in MISSING},
        "table_1": _table_1(rows),
        "table_2": _table_2(rows),
        "stability": _stability(config, rows),
    }
    pages = {"comparison": page_parts(table, summary, figures)}
    pushes = {
        "pushes": pushes_table(rows, "pushes", _PUSHES),
        "pushed_arm": pushes_table(rows, "pushed arm", _PUSHES_OF_THE_ARM),
    }
    return Report(table, figures, summary, pages, pushes)


def _of_recordings(config: Any, rows: list[Row]) -> Report:
    """Geometric means over all sets, and the means of each set."""
    methods = dict.fromkeys(row["method"] for row in rows)
    table = [
        line
        for reference in _REFERENCES
        if reference in methods
        for line in relative(rows, reference=reference, seed=config.seed)
    ]
    sets = [
        {
            "set": name,
            "method": method,
            "demonstrations": len(own),
            "refused": sum("refused" in row for row in own),
            **{error: mean(own, error) for error in ERRORS},
        }
        for name, _ in config.recordings
        for method in methods
        if (own := selected(rows, set=name, method=method))
    ]
    return Report(table, tables={"sets": sets})


def _drawings(config: Any, rows: list[Row]) -> list[Row]:
    return [
        {**_line(protocol, method, own, _DRAWING), "violations": _violations(rows, method)}
        for protocol in ("LOO", "IN")
        for method in config.points
        if (own := selected(rows, study="drawings", protocol=protocol, method=method))
    ]


def _others(config: Any, rows: list[Row]) -> list[Row]:
    """The courses, then the motions of poses."""
    return [
        _line(name, method, own, columns)
        for study, motions, columns in (
            ("courses", config.courses, _COURSE),
            ("poses", config.motions_of_poses, _POSE),
        )
        for name, _ in motions
        for method in (config.points if study == "courses" else config.poses)
        if (own := selected(rows, study=study, task=name, method=method))
    ]


def pushes_table(rows: list[Row], study: str, columns: tuple[str, ...]) -> list[Row]:
    """The mean responses of every method to pushes, of all drawings and of each other motion."""
    pushed: dict[tuple[str, str], list[Row]] = {}
    for row in selected(rows, study=study):
        motion = "drawings" if row["part"] == "drawings" else str(row["task"])
        pushed.setdefault((motion, row["method"]), []).append(row)
    return [
        {
            "motion": motion,
            "method": method,
            "n": len(own),
            "refused": sum("refused" in row for row in own),
            **{name: mean(own, name) for name in columns},
        }
        for (motion, method), own in pushed.items()
    ]


def _line(part: str, method: str, rows: list[Row], columns: tuple[str, ...]) -> Row:
    """One row of the table; columns of the other parts are empty.

    Times are medians, as the first call of a library also loads it; all others are means.
    """
    every = dict.fromkeys((*_DRAWING, *_POSE, "violations"))
    found = {name: (_median if name in _COSTS else mean)(rows, name) for name in columns}
    refused = sum("refused" in row for row in rows)
    return {"part": part, "method": method, "n": len(rows), "refused": refused, **every, **found}


def _violations(rows: list[Row], method: str) -> int | None:
    """Starts that did not arrive, energies that rose and other places of rest, of all motions."""
    own = selected(rows, study="stability", method=method)
    return sum(row["violations"] for row in own) if own else None


def _median(rows: list[Row], column: str) -> float | None:
    values = [row[column] for row in rows if column in row]
    return float(np.median(values)) if values else None


def _first(table: list[Row]) -> dict[str, list[str]]:
    """The methods of each part, the best first: by area, or by distance under time warping."""
    order = {}
    for part in dict.fromkeys(row["part"] for row in table):
        column = "SEA_mm2" if part in {"LOO", "IN"} else "DTW_mm"
        own = [row for row in selected(table, part=part) if row[column] is not None]
        order[part] = [row["method"] for row in sorted(own, key=lambda row: row[column])]
    return order


def _table_1(rows: list[Row]) -> list[Row]:
    """Table 1 as printed, and what our runs say of stability and of six dimensions."""
    lines = []
    for name, printed in TABLE_1.items():
        method = TABLE_2[name][2]
        known = selected(rows, study="stability", method=method)
        violations = _violations(rows, method)
        poses = [row for row in selected(rows, study="poses", method=method) if "DTW_mm" in row]
        lines.append(
            {
                "method": name,
                "printed": list(printed),
                "violations": violations,
                "starts": sum(row["starts"] for row in known) if known else None,
                "motions of poses made": len(poses),
            }
        )
    return lines


def _table_2(rows: list[Row]) -> list[Row]:
    """Table 2 as printed beside our means, IN, also in the units that the paper may have meant."""
    lines = []
    for name, (area, speed, method) in TABLE_2.items():
        own = selected(rows, study="drawings", protocol="IN", method=method)
        ours = mean(own, "SEA_mm2")
        lines.append(
            {
                "method": name,
                "SEA_printed": area,
                "SEA_sum_of_7_px2": _times(ours, 7 * PIXELS_PER_MM**2),
                "SEA_sum_of_30_px2": _times(ours, 30 * PIXELS_PER_MM**2),
                "SEA_mm2": ours,
                "V_rmse_printed": speed,
                "V_rmse_px_s": _times(mean(own, "V_rmse_mm_s"), PIXELS_PER_MM),
                "V_rmse_mm_s": mean(own, "V_rmse_mm_s"),
            }
        )
    return lines


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def _stability(config: Any, rows: list[Row]) -> list[Row]:
    found = selected(rows, study="stability")
    return [
        {
            "method": method,
            "motions": len(own),
            **{name: sum(row[name] for row in own) for name in ("starts", "arrived", "rising")},
            "resting": sum(row["resting"] for row in own),
            "longest": max(row["longest"] for row in own),
        }
        for method in config.points
        if (own := selected(found, method=method))
    ]


def _errors_figure(config: Any, rows: list[Row]) -> Figure:
    figure = Figure(figsize=(11.0, 0.3 * len(config.points) + 1.5), layout="constrained")
    shown = selected(rows, study="drawings")
    both = zip(figure.subplots(1, 2, sharey=True), ("SEA_mm2", "V_rmse_mm_s"), strict=True)
    for axes, column in both:
        for i, protocol in enumerate(("LOO", "IN")):
            means = [
                mean(selected(shown, method=name, protocol=protocol), column) or 0.0
                for name in config.points
            ]
            places = np.arange(len(means)) + 0.4 * i
            axes.barh(places, means, 0.4, label=protocol)
        axes.set_xlabel("SEA, mm²" if column == "SEA_mm2" else "V_rmse, mm/s")
    axes.set_yticks(np.arange(len(config.points)) + 0.2, config.points)
    axes.invert_yaxis()
    axes.legend()
    return figure


def _paths_figure(motions: tuple[str, ...], rows: list[Row]) -> Figure:
    """The first left-out drawing of every motion, as some methods make it."""
    lines = -(-len(motions) // 5)
    figure = Figure(figsize=(11.0, 2.3 * lines), layout="constrained")
    panels = figure.subplots(lines, 5, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    own = selected(rows, study="drawings", protocol="LOO", tested=0)
    for axes, name in zip(panels, motions, strict=False):
        tested = lasa.load(name)[0].motion.positions
        plot.draw_paths(axes, [tested], plot.DEMONSTRATION, label="left out")
        for method in _PICTURED:
            for row in selected(own, motion=name, method=method):
                if "path" in row:
                    axes.plot(*np.array(row["path"]).T, linewidth=0.9, label=method)
        axes.set_title(name, fontsize=8)
        axes.set_aspect("equal")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6, fontsize=7)
    return figure
