from . import plot
from .page import InlineScene
from .plot import placement_figure, reach_figure
from .reports import simulation_page, simulation_parts, write_validation
from .viewing import inline, open_view, view

__all__ = [
    "InlineScene",
    "inline",
    "open_view",
    "placement_figure",
    "plot",
    "reach_figure",
    "simulation_page",
    "simulation_parts",
    "view",
    "write_validation",
]
