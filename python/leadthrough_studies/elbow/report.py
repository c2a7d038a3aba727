"""Table and figure of the obstacles in the elbow's way."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, selected


def report(config: Any, rows: list[Row]) -> Report:
    """Per kind: how many scenes are solved, of those that can be, and how fast; what others do."""
    own = selected(rows, by="follow")
    kinds = dict.fromkeys(row["motion"] for row in own)
    parts = [(a, m, selected(rows, arm=a, motion=m)) for a in config.arms for m in kinds]
    table = [_row(arm, motion, part) for arm, motion, part in parts if part]
    failures = [row["failure"] for row in own if not row["solved"] and not row["impossible"]]
    figures = {"times": _times_figure(own)} if own else {}
    summary = {"failures": failures, "solved_by_the_reference_alone": _missed(rows)}
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
        **_beside(solved, selected(rows, by="reference"), selected(rows, by="RRT-Connect")),
    }


def _beside(solved: list[Row], references: list[Row], connections: list[Row]) -> Row:
    """Of the scenes compared: what the slow search solves, of these what `follow` solves too."""
    own = {row["index"] for row in solved}
    by_reference = {row["index"] for row in selected(references, solved=1)}
    by_connection = selected(connections, solved=1)
    astray = [row["off_path_m"] for row in by_connection]
    return {
        "compared": len(references),
        "reference_solved": len(by_reference),
        "both_solved": len(own & by_reference),
        "share_of_reference": len(own & by_reference) / len(by_reference) if by_reference else None,
        "reference_median_cpu_s": _median([row["reference_cpu_s"] for row in references]),
        "connect_solved": len(by_connection) if connections else None,
        "connect_median_cpu_s": _median([row["connect_cpu_s"] for row in by_connection]),
        "connect_median_off_path_m": _median(astray),
    }


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None


def _missed(rows: list[Row]) -> list[Row]:
    """The scenes that only the slow search solves."""
    own = {_scene(row) for row in selected(rows, by="follow", solved=1)}
    found = selected(rows, by="reference", solved=1)
    keys = [_scene(row) for row in found if _scene(row) not in own]
    return [{"arm": arm, "motion": motion, "index": index} for arm, motion, index in keys]


def _scene(row: Row) -> tuple[str, str, int]:
    return row["arm"], row["motion"], row["index"]


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
