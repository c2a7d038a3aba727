"""Reachable poses of an arm, its manipulability there, and the base position for a motion."""

from leadthrough.reachability.placement import Placement as Placement, place_base as place_base
from leadthrough.reachability.reach_map import (
    ReachMap as ReachMap,
    reach_map as reach_map,
    spread_orientations as spread_orientations,
)
