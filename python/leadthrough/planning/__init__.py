"""Planning in space: grids, arrival times, distances and the quickest paths."""

from leadthrough.planning.arrival import (
    ArrivalField as ArrivalField,
    FieldUpdate as FieldUpdate,
    arrival_times as arrival_times,
    arrival_times_batch as arrival_times_batch,
    nearest_sources as nearest_sources,
)
from leadthrough.planning.fm2 import (
    Plan as Plan,
    descend as descend,
    direction as direction,
    fm2_speed as fm2_speed,
    plan as plan,
    plan_many as plan_many,
)
from leadthrough.planning.grid import Grid as Grid
from leadthrough.planning.speed_map import (
    distance_transform as distance_transform,
    occupied as occupied,
    occupied_by_points as occupied_by_points,
)
