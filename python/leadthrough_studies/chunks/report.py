"""Table and figure of the chunks that were followed."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Report, Row, selected

_INSIDE = 1.0 + 1e-6  # of a limit
_USES = ("velocity_use", "acceleration_use", "jerk_use")


def report(config: Any, rows: list[Row]) -> Report:
    """Per fault and method: streams beyond limits and with contacts, lag, jerk and ends reached.

    The table `arms` has the same for each arm.
    """
    methods = list(dict.fromkeys(row["method"] for row in rows))
    table = _table(config.faults, methods, rows)
    arms = [
        {"arm": arm} | row
        for arm in config.arms
        for row in _table(config.faults, methods, selected(rows, arm=arm))
    ]
    figures = {"chunks": _figure(table, config.faults, methods)} if rows else {}
    return Report(table, figures, tables={"arms": arms})


def _table(faults: tuple[str, ...], methods: list[str], rows: list[Row]) -> list[Row]:
    return [
        _row(fault, method, part)
        for fault in (*faults, "all")
        for method in methods
        if (part := [r for r in selected(rows, method=method) if fault in (r["fault"], "all")])
    ]


def _row(fault: str, method: str, rows: list[Row]) -> Row:
    calls = [row for row in rows if "p99_call_ms" in row]
    lags = [row["lag_ms"] for row in rows if row["lag_ms"] is not None]
    return {
        "fault": fault,
        "method": method,
        "streams": len(rows),
        "beyond_limits": sum(max(row[use] for use in _USES) > _INSIDE for row in rows),
        **{f"max_{use}": max(row[use] for row in rows) for use in _USES},
        "with_contacts": sum(row["contacts"] > 0 for row in rows),
        "median_lag_ms": float(np.median(lags)) if lags else None,
        "max_lag_ms": max(lags, default=None),
        "mean_error_rad": float(np.mean([row["error_rad"] for row in rows])),
        "jerk_rms": float(np.sqrt(np.mean([row["jerk_rms"] ** 2 for row in rows]))),
        "reached": sum(row["reached"] for row in rows),
        "p99_call_ms": max((row["p99_call_ms"] for row in calls), default=None),
        "max_call_ms": max((row["max_call_ms"] for row in calls), default=None),
    }


def _figure(table: list[Row], faults: tuple[str, ...], methods: list[str]) -> Figure:
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for number, method in enumerate(methods):
        jerks = [selected(table, fault=each, method=method)[0]["jerk_rms"] for each in faults]
        at = np.arange(len(faults)) + 0.2 * (number - 0.5 * (len(methods) - 1))
        axes.bar(at, jerks, 0.18, label=method)
    axes.axhline(1.0, color="0.5", linewidth=1)
    axes.set(yscale="log", ylabel="jerk, RMS, in limits of it")
    axes.set_xticks(np.arange(len(faults)), faults)
    axes.legend(ncols=len(methods))
    return figure
