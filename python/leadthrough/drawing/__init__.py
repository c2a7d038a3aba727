"""Figures of objects by matplotlib: panels that describe them, their style and colours."""

from leadthrough.drawing.drawn import Drawn
from leadthrough.drawing.panels import (
    Dot,
    Line,
    Panel,
    bars,
    of_joints,
    of_points,
    of_poses,
    on_paper,
    over,
    spans_over_time,
    triad,
)

__all__ = [
    "Dot",
    "Drawn",
    "Line",
    "Panel",
    "bars",
    "of_joints",
    "of_points",
    "of_poses",
    "on_paper",
    "over",
    "spans_over_time",
    "triad",
]
