"""Figures of where an arm reaches, and of placements of its base."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from leadthrough.check import Float64Array
from leadthrough.drawing.figure import styled
from leadthrough.reachability.reach_map import Placement, ReachMap

_SIDES = ((0, 2, "x", "z"), (0, 1, "x", "y"))  # seen from the side, and from above


def reach_figure(reach_map: ReachMap) -> Figure:
    """The best of each line of sight, from the side and from above: reach and manipulability."""
    with styled():
        figure = Figure(figsize=(8.5, 7.5))
        panels = figure.subplots(2, 2)
        values = {
            "orientations reached": reach_map.fraction,
            "manipulability": reach_map.manipulability,
        }
        for row, (first, second, *names) in zip(panels, _SIDES, strict=True):
            for axes, (label, value) in zip(row, values.items(), strict=True):
                seen = value.max(axis=3 - first - second)
                drawn = axes.pcolormesh(
                    _edges(reach_map.axes[first], reach_map.spacing),
                    _edges(reach_map.axes[second], reach_map.spacing),
                    np.where(seen > 0.0, seen, np.nan).T,
                    vmin=0.0,
                )
                axes.set(xlabel=f"{names[0]} / m", ylabel=f"{names[1]} / m", aspect="equal")
                figure.colorbar(drawn, ax=axes, label=label)
    return figure


def placement_figure(placement: Placement) -> Figure:
    """Best manipulability by base position, over all heights and yaws."""
    positions, where = np.unique(placement.bases[:, :2], axis=0, return_inverse=True)
    best, most = np.zeros(len(positions)), np.zeros(len(positions))
    np.maximum.at(best, where.ravel(), placement.manipulability)
    np.maximum.at(most, where.ravel(), placement.fraction)
    with styled():
        figure = Figure(figsize=(5.5, 4.5))
        axes = figure.add_subplot()
        whole = best > 0.0
        x, y = positions.T
        axes.scatter(x[~whole], y[~whole], c="lightgray", s=12 + 60 * most[~whole])
        drawn = axes.scatter(x[whole], y[whole], c=best[whole], s=80, vmin=0.0)
        if placement.best is not None:
            axes.plot(placement.best[0], placement.best[1], "x", color="black")
        axes.set(xlabel="x of the base / m", ylabel="y of the base / m", aspect="equal")
        figure.colorbar(drawn, ax=axes, label="least manipulability along the motion")
    return figure


def _edges(centres: Float64Array, spacing: float) -> Float64Array:
    return np.append(centres, centres[-1] + spacing) - 0.5 * spacing
