"""Objects that draw themselves: as the result of a notebook's cell, and by `plot` as a figure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from leadthrough.check import LeadthroughError, ShortRepr

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadthrough.drawing.panels import Panel


class Drawn(ShortRepr, ABC):
    """Classes that derive from this one show a drawing in notebooks, and have `plot`."""

    __slots__ = ()

    def plot(self) -> Figure:
        """A figure of matplotlib, which `savefig` writes to a file.

        Raises:
            LeadthroughError: if there is nothing to draw, with the reason.
        """
        from leadthrough.drawing.figure import figure_of

        return figure_of(self._panels())

    @abstractmethod
    def _panels(self) -> Sequence[Panel]:
        """The panels to draw, side by side."""

    def _repr_html_(self) -> str:
        """A drawing with the short text below it; the text alone where nothing can be drawn."""
        from leadthrough.drawing.figure import svg_of

        try:
            picture = svg_of(self.plot(), type(self).__name__)
        except LeadthroughError as error:
            picture = f"<p>{escape(str(error))}</p>"
        return f"<div>{picture}<pre>{escape(repr(self))}</pre></div>"
