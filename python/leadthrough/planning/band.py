"""The quickest path through a map, marched only where it can lie."""

from __future__ import annotations

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.planning.speed_field import SpeedField


def quickest(field: SpeedField, start: Float64Array, goal: Float64Array) -> Float64Array:
    """The path (n, d) of least time, the same as in a march through the whole map.

    Its cost grows with the path, not with the map. One of the ends may lie outside the grid: the
    path is straight between it and the first cell.

    Args:
        field: speeds in cells.
        start: (d,).
        goal: (d,).

    Raises:
        NoPath: where an end lies in an obstacle, or obstacles separate them.
    """
    with check.enough_memory(f"resolution: a grid of shape {field.grid.shape}"):
        status, path = field.compiled.quickest(start.tolist(), goal.tolist())
    if status == "separated":
        raise NoPath("goal: obstacles separate it from the start", reason="goal_enclosed")
    if status != "found":
        name, point = ("start", start) if status == "start_in_wall" else ("goal", goal)
        raise NoPath(f"{name}: {point} lies in an obstacle", reason=status)
    return path
