"""Figures 4.1 to 4.4 of Grioli's notes (2023), from the rows of `generalization`."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from leadthrough_studies.study import Row, selected
from leadthrough_studies.trajectories.generalization import demonstrations

_STEPS = 4  # steps of k-means that are drawn, the seeds first


def figures(rows: list[Row], seed: int) -> dict[str, Figure]:
    """The figures of those rows that there are, by file stem.

    Args:
        rows: of the study.
        seed: of its demonstrations.
    """
    found = {}
    for row in selected(rows, study="combination"):
        found["figure_4_1"] = _combination(row)
    steps = selected(rows, study="k-means")
    for row in selected(rows, study="regression"):
        if steps:
            found["figure_4_2"] = _regression(row, steps[-1], seed)
    if steps:
        found["figure_4_3"] = _clusters(steps[:1], seed)
        found["figure_4_4"] = _clusters(steps, seed)
    return found


def lines(rows: list[Row]) -> list[Row]:
    """Lines of the table: study, what, measure and value.

    Args:
        rows: of the study.
    """
    found = [
        ("combination", "weighted Gaussians", "error_m", row["error_m"])
        for row in selected(rows, study="combination")
    ]
    steps = selected(rows, study="k-means")
    if steps:
        rises = np.diff([row["inertia"] for row in steps])
        found += [
            ("k-means", "random points", "steps", len(steps)),
            ("k-means", "random points", "largest_rise", float(rises.max(initial=-np.inf))),
        ]
    found += [
        ("seeding", row["seeding"], measure, row[measure])
        for row in selected(rows, study="seeding")
        for measure in ("first_inertia", "inertia", "worst_inertia", "steps")
    ]
    for row in selected(rows, study="regression"):
        found += [
            ("regression", "EM", "least_gain", row["least_gain"]),
            ("regression", "EM", "least_ratio", row["least_ratio"]),
            ("regression", "GMR", "error_m", row["error_m"]),
        ]
    names = ("study", "what", "measure", "value")
    return [dict(zip(names, each, strict=True)) for each in found]


def _combination(row: Row) -> Figure:
    figure = Figure(figsize=(5.0, 3.5), layout="constrained")
    axes = figure.subplots()
    for part in row["parts"]:
        axes.plot(row["times"], part, color="0.7", linewidth=0.8)
    axes.plot(row["times"], row["shown"], linewidth=3.0, alpha=0.4, label="demonstration")
    axes.plot(row["times"], row["made"], label="sum of the weighted Gaussians")
    axes.set_xlabel("time, s")
    axes.set_ylabel("y, m")
    axes.legend()
    return figure


def _regression(row: Row, clusters: Row, seed: int) -> Figure:
    shown = demonstrations(seed).reshape(-1, 4)
    mean, deviation = np.array(row["mean"]), np.array(row["deviation"])
    middles = np.array(row["components"])
    figure = Figure(figsize=(9.0, 4.8), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True)
    for i in range(3):
        above, below = panels[:, i]
        above.scatter(shown[:, 0], shown[:, i + 1], c=clusters["labels"], cmap="tab10", s=3)
        above.set_ylabel(f"{'xyz'[i]}, m")
        for one in np.split(shown, len(shown) // 120):
            below.plot(one[:, 0], one[:, i + 1], color="0.75", linewidth=0.8)
        low, high = (mean[:, i] + side * deviation[:, i] for side in (-2.0, 2.0))
        below.fill_between(row["times"], low, high, alpha=0.25)
        below.plot(row["times"], mean[:, i])
        below.plot(middles[:, 0], middles[:, i + 1], "k+")
        below.set_ylabel(f"{'xyz'[i]}, m")
        below.set_xlabel("time, s")
    return figure


def _clusters(steps: list[Row], seed: int) -> Figure:
    """Clusters of y over time at evenly spaced steps, with the centres that the step begins at."""
    shown = demonstrations(seed).reshape(-1, 4)
    middle, scale = shown.mean(axis=0), shown.std(axis=0)
    chosen = np.unique(np.linspace(0, len(steps) - 1, min(_STEPS, len(steps))).round().astype(int))
    figure = Figure(figsize=(3.2 * len(chosen), 3.2), layout="constrained")
    panels = figure.subplots(1, len(chosen), squeeze=False).ravel()
    for axes, i in zip(panels, chosen, strict=True):
        centres = np.array(steps[i]["centres"]) * scale + middle
        axes.scatter(shown[:, 0], shown[:, 2], c=steps[i]["labels"], cmap="tab10", s=3)
        axes.plot(centres[:, 0], centres[:, 2], "k*", markersize=9)
        axes.set_title("random points" if i == 0 else f"step {steps[i]['step']}")
        axes.set_xlabel("time, s")
    panels[0].set_ylabel("y, m")
    return figure
