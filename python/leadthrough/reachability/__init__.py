"""Reachable poses of an arm, its manipulability there, and the base position for a motion."""

from leadthrough.reachability.reach_map import (
    Placement as Placement,
    ReachMap as ReachMap,
    place_base as place_base,
    reach_map as reach_map,
    spread_orientations as spread_orientations,
)
