from . import plot
from .simulated import simulation_page
from .validation_page import write_validation
from .viewing import open_view, view

__all__ = ["open_view", "plot", "simulation_page", "view", "write_validation"]
