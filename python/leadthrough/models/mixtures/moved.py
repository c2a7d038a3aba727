"""A motion for a moved start and goal that stays as near to the usual one as its ends do.

Frames carry a motion as far as demonstrations support it. From few of them, or where all share an
end, a mixture may conclude far more than a moved end allows. So the motion is the usual one with
the offsets of its ends faded into each other, and of what the frames make of it beyond that as
much as keeps every phase within 1.45 times the ends' own way. A turned frame counts as the way of
the point of the motion that is farthest from it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import NoContinuousLogarithm
from leadthrough.models.bounded import MOST_GAIN, fraction_inside
from leadthrough.motion import MotionT, PoseTrajectory, normalised_times
from leadthrough.preprocess.resample import arc_length


def bounded(carried: MotionT, usual: MotionT) -> MotionT:
    """A motion between moved ends, no farther from the usual one than the bound."""
    way = _way(carried, usual)
    limits = _limits(way, usual.positions)
    offsets = _within(way.offsets, way.fractions, limits[0])
    positions = usual.positions + offsets
    if not isinstance(carried, PoseTrajectory) or not isinstance(usual, PoseTrajectory):
        return replace(carried, positions=positions)
    turns = rotations.exp(_within(way.turns, way.fractions, limits[1]))
    turned = rotations.align_signs(rotations.compose(usual.orientations, turns))
    return replace(carried, positions=positions, orientations=turned)


@dataclass(frozen=True, eq=False)
class _Way:
    """How far a motion is from the usual one."""

    offsets: Float64Array  # (n, d) of the positions
    turns: Float64Array
    fractions: Float64Array  # (n,) of the usual path covered


def _way(carried: MotionT, usual: MotionT) -> _Way:
    covered = arc_length(usual.positions)
    total = float(covered[-1])
    fractions = covered / total if total > 0.0 else normalised_times(usual.times)
    offsets = carried.positions - usual.positions
    turns = np.zeros((len(offsets), 3))
    if isinstance(carried, PoseTrajectory) and isinstance(usual, PoseTrajectory):
        turns = _turns(usual.orientations, carried.orientations, fractions)
    return _Way(offsets, turns, fractions)


def _turns(usual: Float64Array, carried: Float64Array, fractions: Float64Array) -> Float64Array:
    """Rotation vectors (n, 3) from usual orientations (n, 4) to carried ones."""
    between = rotations.compose(rotations.inverse(usual), carried)
    try:
        return rotations.lift(between)
    except NoContinuousLogarithm:
        ends = rotations.log(between[[0, -1]])
        return np.outer(1.0 - fractions, ends[0]) + np.outer(fractions, ends[1])


def _limits(way: _Way, positions: Float64Array) -> tuple[float, float]:
    """The largest distance and the largest turn, rad, from the usual motion."""
    ends = [0, -1]
    levers = [float(np.linalg.norm(positions - positions[i], axis=1).max()) for i in ends]
    moved = [float(np.linalg.norm(way.offsets[i])) for i in ends]
    turned = [float(np.linalg.norm(way.turns[i])) for i in ends]
    pairs = list(zip(moved, turned, levers, strict=True))
    distance = max(m + t * lever for m, t, lever in pairs)
    angle = max(t + (m / lever if lever > 0.0 else 0.0) for m, t, lever in pairs)
    return MOST_GAIN * distance, MOST_GAIN * angle


def _within(changes: Float64Array, fractions: Float64Array, limit: float) -> Float64Array:
    """Changes (n, d) with those of the ends, drawn to their fade as far as the limit asks."""
    fade = np.outer(1.0 - fractions, changes[0]) + np.outer(fractions, changes[-1])
    more = changes - fade
    return np.asarray(fade + fraction_inside(fade, more, limit) * more)
