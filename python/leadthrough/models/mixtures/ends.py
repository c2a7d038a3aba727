"""Start and goal of a motion, as a query asks for them, and motions moved to them."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.chart import Chart
from leadthrough.models.place import Place


def wanted_ends(
    chart: Chart, ends: Float64Array, start: Place | None, goal: Place | None
) -> Float64Array:
    """Start and goal (2, d), where a query leaves them open those of the demonstrations."""
    wanted = ends.copy()
    for row, (place, name) in enumerate(((start, "start"), (goal, "goal"))):
        if place is not None:
            given = chart.target(place, name, float(row))
            wanted[row, : len(given)] = given
    return wanted


def shifted(columns: Float64Array, fractions: Float64Array, ends: Float64Array) -> Float64Array:
    """A motion moved to other ends; the offset at each end fades linearly towards the other."""
    offsets = ends - columns[[0, -1]]
    from_start, from_goal = np.outer(1.0 - fractions, offsets[0]), np.outer(fractions, offsets[1])
    return np.asarray(columns + from_start + from_goal)
