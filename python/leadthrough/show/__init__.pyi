from . import plot
from .inline import InlineScene, inline
from .reach_picture import placement_figure, reach_figure
from .simulated import simulation_page, simulation_parts
from .validation_page import write_validation
from .viewing import open_view, view

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
