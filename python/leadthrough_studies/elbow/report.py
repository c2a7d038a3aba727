"""Table and figure of the obstacles in the elbow's way."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, selected


def report(config: Any, rows: list[Row]) -> Report:
    """Per arm: how many scenes are solved, of those that can be, and how fast."""
    arms = [arm for arm in config.arms if selected(rows, arm=arm)]
    table = [_row(arm, selected(rows, arm=arm)) for arm in arms]
    failures = [row["failure"] for row in rows if not row["solved"] and not row["impossible"]]
    figures = {"times": _times_figure(arms, rows)} if arms else {}
    return Report(table=table, figures=figures, summary={"failures": failures})


def _row(arm: str, rows: list[Row]) -> Row:
    solved = [row for row in rows if row["solved"]]
    possible = len(rows) - sum(row["impossible"] for row in rows)
    times = [row["follow_cpu_s"] for row in rows]
    return {
        "arm": arm,
        "scenes": len(rows),
        "touch_without": sum(row["touches_without"] for row in rows),
        "possible": possible,
        "solved": len(solved),
        "clear": sum(row["clear"] for row in solved),
        "solved_share": len(solved) / possible if possible else None,
        "median_cpu_s": float(np.median(times)),
        "p95_cpu_s": float(np.quantile(times, 0.95)),
        "least_distance_m": min((row["distance_m"] for row in solved), default=None),
        "most_tip_error_m": max((row["tip_error_m"] for row in solved), default=None),
    }


def _times_figure(arms: list[str], rows: list[Row]) -> Figure:
    figure = Figure(figsize=(6.0, 3.4), layout="constrained")
    axes = figure.subplots()
    for arm in arms:
        times = np.sort([row["follow_cpu_s"] for row in selected(rows, arm=arm)])
        axes.plot(times, np.arange(1, len(times) + 1) / len(times), label=arm)
    axes.set(xscale="log", xlabel="processor time of `follow` in s", ylabel="share of the scenes")
    axes.legend()
    return figure
