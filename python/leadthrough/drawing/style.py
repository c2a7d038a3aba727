"""The style of all figures: colours, fonts and lines.

Figures are drawn inside `applied`, so that the user's matplotlib settings stay as they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cycler import cycler
from matplotlib import rc_context

from leadthrough.drawing import palette

_LINE = "#b8c0c9"
STYLE: Any = {  # matplotlib's rcParams: the type of their names is not the same in all its versions
    "axes.axisbelow": True,
    "axes.edgecolor": _LINE,
    "axes.labelcolor": palette.BLACK,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": cycler(color=palette.CYCLE),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlecolor": palette.BLACK,
    "axes.titlesize": 10.0,
    "font.size": 9.0,
    "image.cmap": "cividis",
    "legend.edgecolor": "none",
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.85,
    "lines.linewidth": 1.4,
    "text.color": palette.BLACK,
    "xtick.color": _LINE,
    "xtick.labelcolor": palette.BLACK,
    "xtick.labelsize": 8.0,
    "ytick.color": _LINE,
    "ytick.labelcolor": palette.BLACK,
    "ytick.labelsize": 8.0,
}


@contextmanager
def applied() -> Iterator[None]:
    """Gives figures made in the block the package's style; also a decorator."""
    with rc_context(STYLE):
        yield
