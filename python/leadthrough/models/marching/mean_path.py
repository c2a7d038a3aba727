"""The path that demonstrations predict between a new start and a new goal, and routes along it.

Each demonstration is adapted to the new ends by shifting and by rotating it; those of the branch
whose start is nearest are averaged over the arc length. Around obstacles the wave plans in a tube
as wide as the detour may become; if they block a branch, another demonstrated one is preferred.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough.check import Float64Array, NoPath
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.route import Query, Route, route_along
from leadthrough.planning.detours import detoured
from leadthrough.planning.maps import (
    CELLS_PER_KNOT,
    Scales,
    grid_over,
    min_distance,
    tube_field,
)
from leadthrough.preprocess.moved_ends import Chords, bounded, with_ends
from leadthrough.preprocess.resample import by_arc_length

_SAMPLES = 1000
# Demonstrations farther apart than this fraction of their length are different branches.
_SAME_BRANCH = 0.1
# A path leaves the demonstrations by at most the move of its ends; below 1 to allow for rounding.
_ROOM = 0.999
# Details of a predicted path that are shorter than this many radii are tremor, not shape.
_KNOTS = 1.6


def along_mean(demonstrations: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The demonstrations' mean path, with the quickest detours around obstacles."""
    blocked = []
    for mean in branches(demonstrations, query.start, query.goal):
        if min_distance(mean.path, query.obstacles) > 0.0:
            return _through(mean, demonstrations, query, scales)
        blocked.append(mean)
    routes, failures = [], []
    for mean in blocked:
        try:
            routes.append(_through(mean, demonstrations, query, scales))
        except NoPath as error:
            failures.append(error)
    if not routes:
        raise failures[0]
    return min(routes, key=lambda route: route.travel_time)


@dataclass(frozen=True, eq=False)
class MeanPath:
    """A predicted path."""

    path: Float64Array  # (n, d), the mean of demonstrations that are evenly spaced in arc length
    weights: Float64Array  # (k,) of the demonstrations; 0 for those of other branches
    region: tuple[Float64Array, Float64Array]


def branches(
    demonstrated: Sequence[Experience], start: Float64Array, goal: Float64Array
) -> Iterator[MeanPath]:
    """The mean paths of the demonstrated branches, that of the nearest start first."""
    curves = _curves_of(tuple(demonstrated))
    shifted = with_ends(curves.points, start, goal)
    adapted = curves.adapted(shifted, start, goal)
    moved = float(np.linalg.norm(np.stack([start, goal]) - curves.nominal_ends, axis=1).max())
    region = curves.region(start, goal, _ROOM * moved)
    for chosen in _branches_near(shifted, curves.starts, start, curves.nominal_length):
        weights = _weights(curves.starts, start, chosen)
        path = np.einsum("j,jnd->nd", weights, adapted)
        if moved > 0.0:
            path = bounded(path, curves.nominal_mean(chosen))
            path = np.clip(path, *region)
        yield MeanPath(path, weights, region)


class _Curves:
    """Demonstrations, evenly spaced in arc length, with what is the same for every query."""

    def __init__(self, demonstrated: Sequence[Experience]) -> None:
        self.points = np.stack([by_arc_length(each.denoised, _SAMPLES) for each in demonstrated])
        self.starts = self.points[:, 0]
        self.nominal_ends = self.points[:, [0, -1]].mean(axis=0)
        self.nominal_length = float(np.mean([each.length for each in demonstrated]))
        self._corners = self.points.min(axis=(0, 1)), self.points.max(axis=(0, 1))
        self._chords = Chords(self.points)
        self._nominal_means: dict[bytes, Float64Array] = {}

    def adapted(
        self, shifted: Float64Array, start: Float64Array, goal: Float64Array
    ) -> Float64Array:
        """The demonstrations (k, n, d), part shifted and part rotated to a new start and goal."""
        (adapted,) = self._chords.adapted(np.stack([start, goal])[None], shifted)
        return np.asarray(adapted)

    def region(
        self, start: Float64Array, goal: Float64Array, room: float
    ) -> tuple[Float64Array, Float64Array]:
        """Corners around the demonstrations, with room, and around start and goal."""
        ends = np.stack([start, goal])
        lower, upper = self._corners
        return np.minimum(lower - room, ends.min(axis=0)), np.maximum(
            upper + room, ends.max(axis=0)
        )

    def nominal_mean(self, chosen: NDArray[np.bool_]) -> Float64Array:
        """The mean (n, d) of those chosen (k,) between the nominal ends."""
        key = chosen.tobytes()
        if key not in self._nominal_means:
            start, goal = self.nominal_ends
            adapted = self.adapted(with_ends(self.points, start, goal), start, goal)
            weights = _weights(self.starts, start, chosen)
            mean = np.asarray(np.einsum("j,jnd->nd", weights, adapted))
            mean.setflags(write=False)
            self._nominal_means[key] = mean
        return self._nominal_means[key]


# The demonstrations of a skill in one direction or the other, for the skills in use at a time.
_curves_of = lru_cache(maxsize=16)(_Curves)


def _branches_near(
    shifted: Float64Array, starts: Float64Array, start: Float64Array, length: float
) -> Iterator[NDArray[np.bool_]]:
    """Groups of demonstrations connected by small steps, that with the nearest start first."""
    neighbours = core.rms_apart(shifted) < _SAME_BRANCH * length
    distance = np.linalg.norm(starts - start, axis=1)
    left = np.ones(len(shifted), dtype=bool)
    while left.any():
        chosen = np.zeros(len(shifted), dtype=bool)
        chosen[int(np.argmin(np.where(left, distance, np.inf)))] = True
        for _ in shifted:
            chosen = chosen | neighbours[chosen].any(axis=0)
        yield chosen
        left &= ~chosen


def _weights(starts: Float64Array, start: Float64Array, chosen: NDArray[np.bool_]) -> Float64Array:
    """Gaussian weights in the distance of the starts, as wide as these are spread; sum 1."""
    squared = ((starts - start) ** 2).sum(axis=1)
    spread = float(starts.var(axis=0, ddof=1).sum()) if len(starts) > 1 else 0.0
    nearer = np.zeros(len(starts))
    if spread > 0.0:
        nearer = -(squared - squared[chosen].min()) / (2.0 * spread)
    weights = np.where(chosen, np.exp(np.where(chosen, nearer, 0.0)), 0.0)
    return np.asarray(weights / weights.sum())


def _through(
    mean: MeanPath, demonstrations: Sequence[Experience], query: Query, scales: Scales
) -> Route:
    """The route along one mean path, around obstacles."""
    nominal = mean.path
    if scales.workspace is not None:
        nominal = np.clip(
            nominal, *scales.workspace
        )  # start and goal decide whether that is an error
        nominal[[0, -1]] = query.ends
    knot_spacing = _KNOTS * scales.radius
    grid, scales = grid_over([nominal], query.obstacles, scales)
    path = detoured(nominal, grid, query.obstacles, scales)
    if path is not nominal:
        knot_spacing = CELLS_PER_KNOT * float(grid.spacing.max())
    chosen = mean.weights > 0.0
    used = tuple(each for each, wanted in zip(demonstrations, chosen, strict=True) if wanted)
    weights = np.ones(len(used))  # whose start is nearest says nothing about the pace
    return route_along(
        path,
        tube_field(nominal, grid, query.obstacles, scales),
        knot_spacing=knot_spacing,
        used=used,
        weights=weights,
        method="mean_path",
        region=mean.region if path is nominal else None,  # a detour needs its room
    )
