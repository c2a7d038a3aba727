"""Panels as a figure of matplotlib, drawn without a display."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.drawing import palette, style
from leadthrough.drawing.panels import Panel

_WIDTH, _HEIGHT = 4.2, 3.2  # of a panel, inches


@style.applied()
def figure(panels: Sequence[Panel]) -> Figure:
    """A figure with the panels side by side."""
    drawn = Figure(figsize=(_WIDTH * len(panels), _HEIGHT), layout="constrained")
    for axes, panel in zip(drawn.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw(axes, panel)
    return drawn


def _draw(axes: Axes, panel: Panel) -> None:
    for band in panel.bands:
        colour = panel.colour(band.line)
        axes.fill_between(band.x, band.lower, band.upper, color=colour, alpha=0.22, linewidth=0)
    for i, line in enumerate(panel.lines):
        axes.plot(
            line.x, line.y, color=panel.colour(i), linewidth=line.width,
            linestyle="--" if line.dashed else "-", label=line.name or None,
        )  # fmt: skip
    for dot in panel.dots:
        if dot.radius:
            axes.plot(dot.x, dot.y, "o", color=dot.colour, markersize=2.0 * dot.radius)
        axes.annotate(
            dot.text, (dot.x, dot.y), xytext=(dot.radius + 2.0, 0.0), textcoords="offset points",
            va="center", fontsize=8,
        )  # fmt: skip
    for at, text in panel.marks:
        axes.axvline(at, color=palette.GREY, linewidth=0.8, linestyle=":")
        axes.annotate(text, (at, 1.0), xycoords=("data", "axes fraction"), va="top", fontsize=8)
    axes.set_title(panel.title, loc="left")
    axes.set_xlabel(panel.x_label)
    if sum(bool(line.name) for line in panel.lines) > 1:
        axes.legend(ncols=2)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_axis_off()
    if panel.rows:
        axes.set_yticks(np.arange(len(panel.rows)), panel.rows)
        axes.set_ylim(len(panel.rows) - 0.5, -0.5)
