from . import plot
from .simulated import simulation_page
from .viewing import open_view, view

__all__ = ["open_view", "plot", "simulation_page", "view"]
