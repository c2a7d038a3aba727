"""Reachable poses of an arm, its manipulability there, and the base position for a motion."""

from leadthrough.reachability.placement import Placement, place_base
from leadthrough.reachability.reach_map import ReachMap, reach_map, spread_orientations

__all__ = ["Placement", "ReachMap", "place_base", "reach_map", "spread_orientations"]
