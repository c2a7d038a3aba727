"""The success rate of a validation over the region of its goals, as a figure."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from leadthrough.check import Float64Array
from leadthrough.drawing.figure import styled
from leadthrough.validation.validation import Validation

_CELLS = 12  # of the map along each axis
_AXES = "xyz"


def success_map(validation: Validation) -> Figure:
    """The success rate over the region of goals, seen along its shortest side."""
    goals = validation.certificate.goals
    sides = goals.upper - goals.lower
    wide = sorted(np.argsort(-sides, kind="stable")[:2].tolist())
    with styled():
        figure = Figure(figsize=(5.5, 4.5))
        _draw(figure, validation, wide, sides)
    return figure


def _draw(figure: Figure, validation: Validation, wide: list[int], sides: Float64Array) -> None:
    goals, axes = validation.certificate.goals, figure.add_subplot()
    names = [_AXES[i] if len(sides) == len(_AXES) else f"coordinate {i + 1}" for i in wide]
    axes.set(xlabel=f"{names[0]} / m", ylabel=f"{names[-1]} / m")
    at = validation.goals[:, wide] if validation.goals.size else np.empty((0, len(wide)))
    known = np.isfinite(at).all(axis=1)
    if len(wide) == 2 and sides[wide].min() > 0.0:
        edges = [np.linspace(goals.lower[i], goals.upper[i], _CELLS + 1) for i in wide]
        every = _counted(at[known], edges)
        good = _counted(at[known & validation.succeeded], edges)
        rate = np.divide(good, every, out=np.full_like(every, np.nan), where=every > 0)
        drawn = axes.pcolormesh(edges[0], edges[1], rate.T, vmin=0.0, vmax=1.0, cmap="viridis")
        figure.colorbar(drawn, ax=axes, label="success rate")
    failed = at[known & ~validation.succeeded]
    if len(failed):
        axes.plot(failed[:, 0], failed[:, -1], ".", color="black", markersize=3)


def _counted(at: Float64Array, edges: list[Float64Array]) -> Float64Array:
    """The number of positions (n, 2) in each cell between the edges."""
    cells = [np.searchsorted(edge, column) - 1 for edge, column in zip(edges, at.T, strict=True)]
    counts = np.zeros((_CELLS, _CELLS))
    np.add.at(counts, tuple(np.clip(each, 0, _CELLS - 1) for each in cells), 1.0)
    return counts
