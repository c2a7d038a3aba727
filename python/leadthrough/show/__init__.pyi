from . import plot
from .viewing import open_view, view

__all__ = ["open_view", "plot", "view"]
