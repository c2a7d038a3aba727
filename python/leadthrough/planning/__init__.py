"""Planning in space: grids, arrival times, distances and the quickest paths."""

from leadthrough.planning.arrival import (
    ArrivalField,
    FieldUpdate,
    arrival_times,
    arrival_times_batch,
    nearest_sources,
)
from leadthrough.planning.descent import descend, direction
from leadthrough.planning.fm2 import Plan, fm2_speed, plan, plan_many
from leadthrough.planning.grid import Grid
from leadthrough.planning.obstacles import distance_transform, occupied, occupied_by_points

__all__ = [
    "ArrivalField",
    "FieldUpdate",
    "Grid",
    "Plan",
    "arrival_times",
    "arrival_times_batch",
    "descend",
    "direction",
    "distance_transform",
    "fm2_speed",
    "nearest_sources",
    "occupied",
    "occupied_by_points",
    "plan",
    "plan_many",
]
