"""Plans through space: grids, arrival times, distances and the quickest paths through them."""

from leadthrough.planning.arrival import arrival_times
from leadthrough.planning.descent import descend
from leadthrough.planning.distance import distance_transform
from leadthrough.planning.grid import Grid
from leadthrough.planning.obstacles import occupied

__all__ = ["Grid", "arrival_times", "descend", "distance_transform", "occupied"]
