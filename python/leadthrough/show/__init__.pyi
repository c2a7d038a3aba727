from . import plot as plot
from .live_session import LivePage as LivePage
from .page import InlineScene as InlineScene
from .plot import placement_figure as placement_figure, reach_figure as reach_figure
from .reports import (
    simulation_page as simulation_page,
    simulation_parts as simulation_parts,
    write_validation as write_validation,
)
from .teaching import teach as teach
from .viewing import inline as inline, open_view as open_view, view as view
