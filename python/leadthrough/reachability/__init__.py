"""Where an arm's tip can be, how well it moves there, and where the arm must stand for a motion."""

from leadthrough.reachability.placement import Placement, place_base
from leadthrough.reachability.reach_map import ReachMap, reach_map, spread_orientations

__all__ = ["Placement", "ReachMap", "place_base", "reach_map", "spread_orientations"]
