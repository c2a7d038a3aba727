"""From what a query asks for to normalised columns about the goal, and back to motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.models.chart import NODES, Chart
from leadthrough.models.place import Place
from leadthrough.motion import MotionT_co


@dataclass(frozen=True, eq=False)
class Situation(Generic[MotionT_co]):
    """A goal, and where a motion starts."""

    chart: Chart[MotionT_co]  # of motions to this goal
    goal: Float64Array  # position or joints (m,) of the goal
    start: Float64Array  # the start (d,) in normalised columns about the goal
    scale: Float64Array  # what columns (d,) were divided by

    def columns(self, x: Float64Array) -> Float64Array:
        """The chart's columns (n, d) of normalised positions (n, d)."""
        columns = x * self.scale
        columns[:, : self.chart.size] += self.goal
        return columns


def situation(
    chart: Chart[MotionT_co],
    ends: Float64Array,
    scale: Float64Array,
    start: Place | None,
    goal: Place | None,
) -> Situation[MotionT_co]:
    """The situation that a query describes; what it leaves open is as demonstrated."""
    size = chart.size
    position = ends[1, :size]
    if goal is not None:
        target = chart.target(goal, "goal", 1.0)
        position = target[:size]
        if len(target) > size:
            chart = _about(chart, chart.orientations(target[None, size:], np.ones(1))[0])
    shown = ends[0].copy()
    if start is not None:
        given = chart.target(start, "start", 0.0)
        if len(given) > size:
            given = np.concatenate([given[:size], _nearest_sheet(given[size:], shown[size:])])
        shown[: len(given)] = given
    shown[:size] -= position
    return Situation(chart, position, shown / scale, scale)


def _about(chart: Chart[MotionT_co], goal: Float64Array) -> Chart[MotionT_co]:
    return replace(chart, reference=np.tile(goal, (len(NODES), 1)))


def _nearest_sheet(turn: Float64Array, shown: Float64Array) -> Float64Array:
    """The rotation vector (3,) of the same rotation that is nearest to the one shown."""
    return min(sheets(turn, shown), key=lambda each: float(np.linalg.norm(each - shown)))


def sheets(turn: Float64Array, axis: Float64Array) -> list[Float64Array]:
    """Rotation vectors (3,) of one rotation: the shortest, and with a turn less and a turn more."""
    angle = float(np.linalg.norm(turn))
    own = turn / angle if angle > 0.0 else axis / max(float(np.linalg.norm(axis)), 1e-300)
    return [(angle + 2.0 * np.pi * k) * own for k in (0, -1, 1)]


def twist(chart: Chart, turned: Float64Array, rate: Float64Array) -> Float64Array:
    """Angular velocities (n, 3) in the base frame of rotation vectors from the goal."""
    local = (rotations.left_jacobian(turned) @ rate[:, :, None])[:, :, 0]
    assert chart.reference is not None
    return np.asarray(local @ rotations.to_matrix(chart.reference[:1])[0].T)
