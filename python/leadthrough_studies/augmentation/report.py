"""Table and figure of the policies' reaches."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.augmentation.policy import REACHED
from leadthrough_studies.intervals import share
from leadthrough_studies.study import Report, Row, selected


def report(config: Any, rows: list[Row]) -> Report:
    """Per data set and training: successes in percent with Wilson's interval, and distances.

    The row of all trainings has the interval that holds those of each.
    """
    table = []
    for data in config.data:
        parts = [selected(rows, data=data, training=i) for i in range(config.trainings)]
        each = [_row(data, str(number), part) for number, part in enumerate(parts) if part]
        if each:
            table += [*each, _all(data, each, selected(rows, data=data))]
    return Report(table, {"augmentation": _figure(config.data, rows)}, _gaps(table))


def _row(data: str, training: str, rows: list[Row]) -> Row:
    count, hits = len(rows), sum(row["success"] for row in rows)
    low, high = share(hits, count)
    distances = np.array([row["distance_m"] for row in rows])
    return {
        "data": data,
        "training": training,
        "episodes": rows[0]["episodes"],
        "goals": count,
        "successes": hits,
        "percent": 100.0 * hits / count,
        "low": low,
        "high": high,
        "near_percent": 100.0 * float(np.mean(distances < REACHED)),
        "median_mm": 1e3 * float(np.median(distances)),
        "p90_mm": 1e3 * float(np.quantile(distances, 0.9)),
        "with_contacts": sum(row["contacts"] > 0 for row in rows),
    }


def _all(data: str, trainings: list[Row], rows: list[Row]) -> Row:
    ends = {"low": min(t["low"] for t in trainings), "high": max(t["high"] for t in trainings)}
    return _row(data, "all", rows) | ends


def _gaps(table: list[Row]) -> dict[str, float]:
    """Percentage points from the upper end of each data set to the lower end of ours."""
    ends = {row["data"]: row for row in selected(table, training="all")}
    if "ours" not in ends:
        return {}
    low = ends.pop("ours")["low"]
    return {f"ours_above_{data}": low - row["high"] for data, row in ends.items()}


def _figure(data: tuple[str, ...], rows: list[Row]) -> Figure:
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    for name in data:
        distances = np.sort([row["distance_m"] for row in selected(rows, data=name)])
        axes.plot(1e3 * distances, 100.0 * np.arange(1, len(distances) + 1) / len(distances))
    axes.axvline(1e3 * REACHED, color="0.5", linewidth=1)
    axes.set(xscale="log", xlabel="distance from the goal, mm", ylabel="goals, %")
    axes.legend(data)
    return figure
