"""How near a path lies to the experience, and paths that are added to it.

Source: Prados et al. 2023, Appl. Sci. 13:2028, eqs. 6 and 7.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import events
from leadthrough.check import Float64Array
from leadthrough.models.marching import orientation
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.time_law import usual_duration
from leadthrough.models.posture import agreed
from leadthrough.planning.grid import Grid
from leadthrough.preprocess.resample import arc_length, by_arc_length

# Points at which the map is looked up, at the most; two per cell otherwise.
_MOST_STEPS = 100_000


def mean_speed(path: Float64Array, grid: Grid, speed: Float64Array, outside: float) -> float:
    """The mean of a speed map along a path, evenly over its length (Prados et al. 2023, eq. 6)."""
    steps = 2.0 * float(arc_length(path)[-1]) / float(grid.spacing.min())
    points = by_arc_length(path, int(min(np.ceil(steps), _MOST_STEPS)) + 2)
    inside = grid.contains(points)
    speeds = np.full(len(points), outside)
    speeds[inside] = speed[tuple(grid.cells_of(points[inside]).T)]
    return float(speeds.mean())


def added(path: Float64Array, known: Sequence[Experience], *, duration: float | None) -> Experience:
    """A path as experience, with the timing, turning, events and joints of what is known."""
    weights = np.ones(len(known))
    progress = np.mean([each.progress for each in known], axis=0)
    covered = arc_length(path)
    length, turned = float(covered[-1]), None
    if known[0].orientations is not None:
        turned = orientation.along(
            known, weights, path=path, start=None, goal=None, fractions=covered / length
        )
    own = duration or usual_duration(known, weights, length)
    happened = events.agreed([each.events for each in known])
    joints = agreed([each.posture for each in known])
    return Experience(path, own, progress, turned, happened, joints)
