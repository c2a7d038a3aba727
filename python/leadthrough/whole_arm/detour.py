"""Paths of the tip, moved aside where one leaves the arm no room."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough.whole_arm.room import Narrows, Room, along, turned

# m that a part of the path is moved by, tried in this order.
_OFFSETS = tuple(0.02 * k for k in (1, 2, 3, 4, 6, 8, 11, 15))
# The way on which the tip leaves its path and comes back, over the offset.
_RAMP = 3.0
# Places of the part that are looked at in each direction.
_PLACES = 9
# To all faces, edges and corners of a cube.
_DIRECTIONS = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)], dtype=float)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1)[:, None]


def paths_beside(
    room: Room, tip: Trajectory | PoseTrajectory, narrows: Narrows, near: Float64Array
) -> Iterator[Trajectory | PoseTrajectory]:
    """The path with a part moved aside to where the arm can stand, by little first."""
    length = along(tip)
    if length[narrows.samples[0]] == 0.0 or length[narrows.samples[-1]] == length[-1]:
        return
    for more, offset in enumerate(_OFFSETS):
        part = narrows.widened(more)
        directions = _with_room(room, tip, part, near, offset)
        if len(directions):
            opposite = directions[np.argmin(directions @ directions[0])]
            for direction in np.unique([directions[0], opposite], axis=0):
                aside = np.outer(_share(tip, part, offset), offset * direction)
                yield replace(tip, positions=tip.positions + aside)


def _with_room(
    room: Room,
    tip: Trajectory | PoseTrajectory,
    part: Narrows,
    near: Float64Array,
    offset: float,
) -> Float64Array:
    """The directions (k, 3) in which the arm can stand at all places of the part."""
    open_ = _DIRECTIONS
    for place in _middle_first(part.samples):
        asked = tip.positions[place] + offset * open_
        rows = np.full(len(open_), place)
        open_ = open_[room.stands(asked, turned(tip, rows), near)]
        if len(open_) == 0:
            break
    return open_


def _middle_first(samples: NDArray[np.int64]) -> NDArray[np.int64]:
    """A few samples spread evenly; most directions fail in the middle, so it is looked at first."""
    count = min(_PLACES, len(samples))
    few = samples[np.linspace(0, len(samples) - 1, count).round().astype(int)]
    order = np.argsort(np.abs(np.arange(count) - 0.5 * (count - 1)), kind="stable")
    return np.asarray(few[order])


def _share(tip: Trajectory | PoseTrajectory, part: Narrows, offset: float) -> Float64Array:
    """How much of the offset each sample is moved by, 0 to 1."""
    length = along(tip)
    first, last = length[part.samples[[0, -1]]]
    before = min(_RAMP * offset, first)
    after = min(_RAMP * offset, length[-1] - last)
    rise = minimum_jerk_time_scaling(np.clip((length - first + before) / before, 0.0, 1.0))
    fall = minimum_jerk_time_scaling(np.clip((last + after - length) / after, 0.0, 1.0))
    return np.asarray(rise * fall)
