"""Where an arm's tip can be, how well it moves there, and where the arm must stand for a motion."""

from leadthrough.reaching.orientations import spread_orientations
from leadthrough.reaching.placement import Placement, place_base
from leadthrough.reaching.reach_map import ReachMap, reach_map

__all__ = ["Placement", "ReachMap", "place_base", "reach_map", "spread_orientations"]
