"""Figures of objects by matplotlib: panels that describe them, their style and colours."""

from leadthrough.drawing.drawn import Drawn as Drawn
from leadthrough.drawing.panels import (
    Dot as Dot,
    Line as Line,
    Panel as Panel,
    bars as bars,
    of_joints as of_joints,
    of_points as of_points,
    of_poses as of_poses,
    on_paper as on_paper,
    over as over,
    spans_over_time as spans_over_time,
    triad as triad,
)
