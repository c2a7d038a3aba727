"""Plans through space: grids, arrival times, distances and the quickest paths through them."""

from leadthrough.planning.arrival import arrival_times, arrival_times_batch
from leadthrough.planning.arrival_field import ArrivalField, FieldUpdate
from leadthrough.planning.descent import descend, direction
from leadthrough.planning.distance import distance_transform
from leadthrough.planning.grid import Grid
from leadthrough.planning.nearest_source import nearest_sources
from leadthrough.planning.obstacles import occupied

__all__ = [
    "ArrivalField",
    "FieldUpdate",
    "Grid",
    "arrival_times",
    "arrival_times_batch",
    "descend",
    "direction",
    "distance_transform",
    "nearest_sources",
    "occupied",
]
