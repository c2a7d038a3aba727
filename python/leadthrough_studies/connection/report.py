"""Table and figure of the published problems."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, selected

_PLANNERS = {"connect_cpu_s": "connect_configurations", "plain_cpu_s": "plain RRT-Connect"}


def report(config: Any, rows: list[Row]) -> Report:
    """Per kind and in all: problems solved and certified, and motions that touch."""
    kinds = [(kind, part) for kind in config.kinds if (part := selected(rows, kind=kind))]
    table = [_row(*each) for each in [*kinds, ("all", rows)] if rows]
    missed = [row for row in selected(rows, certified=0) if row["plain_solved"]]
    summary = {"solved_by_plain_alone": [[row["kind"], row["number"]] for row in missed]}
    return Report(table, {"times": _times(rows)} if rows else {}, summary)


def _row(kind: str, rows: list[Row]) -> Row:
    compared = [row for row in rows if "compared" in row]
    return {
        "kind": kind,
        "problems": len(rows),
        "ends_clear": sum(row["ends_clear"] for row in rows),
        "solved": sum(row["solved"] for row in rows),
        "certified": sum(row["certified"] for row in rows),
        "median_cpu_s": float(np.median([row["connect_cpu_s"] for row in rows])),
        "p95_cpu_s": float(np.quantile([row["connect_cpu_s"] for row in rows], 0.95)),
        "plain_solved": sum(row["plain_solved"] for row in rows),
        "plain_touches": sum(row["plain_touches"] for row in rows),
        "plain_median_cpu_s": float(np.median([row["plain_cpu_s"] for row in rows])),
        "compared_with_coal": sum(row["compared"] for row in compared),
        "verdicts_differ": sum(row["verdicts_differ"] for row in compared),
        "distance_differs_m": max((row["distance_differs_m"] for row in compared), default=None),
    }


def _times(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(6.0, 3.4), layout="constrained")
    axes = figure.subplots()
    for column, label in _PLANNERS.items():
        times = np.sort([row[column] for row in rows])
        axes.plot(times, np.arange(1, len(times) + 1) / len(times), label=label)
    axes.set(xscale="log", xlabel="processor time in s", ylabel="fraction of the problems")
    axes.legend()
    return figure
