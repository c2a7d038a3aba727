"""Figures of matplotlib in the package's style, and their SVG for HTML pages.

Figures are drawn inside `styled`, so that the user's matplotlib settings stay as they are. Figures
of your own have the style after `plt.style.use("leadthrough.drawing.figures")`.
"""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context, rc_params_from_file
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.drawing import palette
from leadthrough.drawing.panels import Panel

# matplotlib's rcParams
STYLE: Any = rc_params_from_file(
    Path(__file__).with_name("figures.mplstyle"), use_default_template=False
)
# Black lines and texts of figures have the colour of the page's own text.
_INK = re.compile(rf"{palette.BLACK}\b|#000000\b")

_WIDTH, _HEIGHT = 4.2, 3.2  # of a panel, inches
_BAND_POINTS = 200  # maximum number of points of a band; more are not visible at this size
_FLAT = 1e-9  # a range below this fraction of its values is rounding
_NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))


@contextmanager
def styled() -> Iterator[None]:
    """Gives figures made in the block the package's style; also a decorator."""
    with rc_context(STYLE):
        yield


@styled()
def figure_of(panels: Sequence[Panel]) -> Figure:
    """A figure with panels side by side, drawn without a display."""
    figure = Figure(figsize=(_WIDTH * len(panels), _HEIGHT), layout="constrained")
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw(axes, panel)
    return figure


def svg_of(figure: Figure, label: str) -> str:
    """A figure as an SVG element for light and dark pages, with a label for screen readers."""
    content = io.StringIO()
    # The same figure gives the same SVG; its texts are rendered by the page.
    with rc_context({"svg.hashsalt": "leadthrough", "svg.fonttype": "none"}):
        figure.savefig(content, format="svg", metadata=_NO_METADATA, facecolor="none")
    svg = _INK.sub("currentColor", content.getvalue()).replace("fill: #ffffff", "fill: none")
    attributes = (
        f'role="img" aria-label="{html.escape(label, quote=True)}" '
        'style="max-width: 100%; height: auto"'
    )
    return f"<svg {attributes}" + svg[svg.index("<svg") + len("<svg") :]


def _draw(axes: Axes, panel: Panel) -> None:
    for band in panel.bands:
        colour = panel.colour(band.line)
        some = np.unique(np.linspace(0, len(band.x) - 1, _BAND_POINTS).round().astype(int))
        axes.fill_between(
            band.x[some], band.lower[some], band.upper[some], color=colour, alpha=0.22, linewidth=0
        )
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
    axes.locator_params(axis="x", nbins=6)
    low, high = axes.get_ylim()
    if high - low < _FLAT * max(abs(low), abs(high)):
        axes.set_ylim(low - 0.5 * abs(low), high + 0.5 * abs(high))
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_axis_off()
    if panel.rows:
        axes.set_yticks(np.arange(len(panel.rows)), panel.rows)
        axes.set_ylim(len(panel.rows) - 0.5, -0.5)
