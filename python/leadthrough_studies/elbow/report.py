"""Table and figure of the obstacles in the elbow's way."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, selected


def report(config: Any, rows: list[Row]) -> Report:
    """Per kind and in all: how many scenes are solved, and how fast; what others do."""
    own = selected(rows, by="follow")
    kinds = dict.fromkeys(row["motion"] for row in own)
    parts = [(a, m, selected(rows, arm=a, motion=m)) for a in config.arms for m in kinds]
    table = [_row(arm, motion, part) for arm, motion, part in parts if part]
    if len(table) > 1:
        table.append(_row("all", "all", rows))
    failures = [row["failure"] for row in own if not row["solved"] and not row["impossible"]]
    figures = {"times": _times_figure(own)} if own else {}
    summary = {"failures": failures, "solved_by_the_search_alone": _missed(rows)}
    return Report(table=table, figures=figures, summary=summary)


def _row(arm: str, motion: str, rows: list[Row]) -> Row:
    own = selected(rows, by="follow")
    solved = selected(own, solved=1)
    times = [row["follow_cpu_s"] for row in own]
    return {
        "arm": arm,
        "motion": motion,
        "scenes": len(own),
        "touch_without": sum(row["touches_without"] for row in own),
        "possible": len(own) - sum(row["impossible"] for row in own),
        "solved": len(solved),
        "clear": sum(row["clear"] for row in solved),
        "median_cpu_s": float(np.median(times)),
        "p95_cpu_s": float(np.quantile(times, 0.95)),
        "least_distance_m": min((row["distance_m"] for row in solved), default=None),
        "most_tip_error_m": max((row["tip_error_m"] for row in solved), default=None),
        **_searched(solved, selected(rows, by="reference")),
        **_rechecked(selected(rows, by="coal")),
        **_connected(selected(rows, by="RRT-Connect")),
    }


def _searched(solved: list[Row], asked: list[Row]) -> Row:
    """Of the scenes that a minute of search solves, or `follow`: those that `follow` solves."""
    alone = len(selected(asked, solved=1))
    either = len(solved) + alone
    return {
        "searched": len(asked),
        "solved_by_the_search_alone": alone,
        "share_of_solvable": len(solved) / either if either else None,
        "search_median_cpu_s": _median([row["reference_cpu_s"] for row in asked]),
    }


def _rechecked(rows: list[Row]) -> Row:
    """Collisions that coal finds along the motions, in steps of at most 0.1 mm."""
    return {
        "rechecked": len(rows),
        "rechecked_steps": sum(row["steps"] for row in rows),
        "touches": sum(row["touches"] for row in rows),
        "least_coal_distance_m": min((row["coal_distance_m"] for row in rows), default=None),
    }


def _connected(rows: list[Row]) -> Row:
    """Figures of RRT-Connect: solved, times, and distances from the demonstrated path."""
    found = selected(rows, solved=1)
    return {
        "asked_of_connect": len(rows),
        "connect_solved": len(found),
        "connect_median_cpu_s": _median([row["connect_cpu_s"] for row in found]),
        "connect_median_off_path_m": _median([row["off_path_m"] for row in found]),
    }


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None


def _missed(rows: list[Row]) -> list[Row]:
    """The scenes that only the slow search solves."""
    found = selected(rows, by="reference", solved=1)
    return [{name: row[name] for name in ("arm", "motion", "index")} for row in found]


def _times_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(6.0, 3.4), layout="constrained")
    axes = figure.subplots()
    for arm, motion in dict.fromkeys((row["arm"], row["motion"]) for row in rows):
        times = np.sort([row["follow_cpu_s"] for row in selected(rows, arm=arm, motion=motion)])
        label = f"{arm}, {motion}"
        axes.plot(times, np.arange(1, len(times) + 1) / len(times), label=label)
    axes.set(xscale="log", xlabel="processor time of `follow` in s", ylabel="share of the scenes")
    axes.legend()
    return figure
