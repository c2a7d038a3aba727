"""Demonstrations that contradict all others: reversed, of another task, rotated, of another pace.

Only a lone one contradicts: two that agree with each other are a second way of doing the task.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.preprocess import arc_length, by_arc_length
from leadthrough.preprocess.align import features
from leadthrough.preprocess.moved_ends import with_ends

Indices = NDArray[np.intp]

_SAMPLES, _ALONG = 400, 100  # rows of a motion, and points of its path
_MAX_OTHERS = 50  # with which each is compared
# A lone one is this many times as far from its nearest neighbour as any other is from its own, and
# farther than a fraction of the extent. On the way back it is nearer by this factor.
_LONE, _FAR, _REVERSED = 4.0, 0.2, 0.4
_ROTATED = 1.2  # rad, likewise; goals of one task are rotated less
_PACE = 4.0  # times as fast as the fastest other, or as slow as the slowest


@dataclass(frozen=True)
class Contradiction:
    """A demonstration that no other agrees with."""

    index: int  # of the demonstration
    text: str  # the difference, to complete "the demonstration ..."


def contradictions(motions: Sequence[Motion]) -> list[Contradiction]:
    """Lone motions that contradict all others; of two, the second may be reversed."""
    if len(motions) < 2:
        return []
    paths = np.array([by_arc_length(each, _ALONG) for each in features(motions, _SAMPLES)])
    found: dict[int, str] = {}
    for index, text in (
        *_reversed(paths),
        *_of_other_paths(paths, motions[0].positions.shape[1]),
        *_rotated(motions),
        *_of_other_pace(motions),
    ):
        found.setdefault(index, text)
    return [Contradiction(index, found[index]) for index in sorted(found)]


def _others(count: int, index: int) -> Indices:
    """Indices of the other motions; of many, evenly chosen ones."""
    rest = np.delete(np.arange(count), index)
    some = np.linspace(0, len(rest) - 1, min(len(rest), _MAX_OTHERS)).round().astype(int)
    return np.asarray(rest[some])


def _reversed(paths: Float64Array) -> Iterator[tuple[int, str]]:
    for i, path in enumerate(paths):
        if len(paths) < 3 and i == 0:
            continue  # of two, the second
        others = paths[_others(len(paths), i)]
        ahead, back = (
            float(np.linalg.norm(others - own, axis=2).mean(axis=1).min())
            for own in (path, path[::-1])
        )
        if ahead > _FAR and back < _REVERSED * ahead:
            yield i, "runs backwards, from the goal of the others to their start"


def _of_other_paths(paths: Float64Array, size: int) -> Iterator[tuple[int, str]]:
    def apart(i: int, others: Indices) -> Float64Array:
        """Distances (others, n) once both ends are carried to those of the others."""
        there = paths[others, :, :size]
        carried = with_ends(paths[i, :, :size], there[:, :1], there[:, -1:])
        return np.asarray(np.linalg.norm(carried - there, axis=2))

    for i, distances in _lone(len(paths), apart, _FAR):
        at = int(np.argmax(distances))
        yield (
            i,
            (
                f"takes a path of its own, {distances[at]:.0%} of the extent from its nearest "
                f"neighbour at {at / (len(distances) - 1):.0%} of the path"
            ),
        )


def _rotated(motions: Sequence[Motion]) -> Iterator[tuple[int, str]]:
    turned = np.array(
        [
            rotations.interpolate(
                along / along[-1], each.orientations, np.linspace(0.0, 1.0, _ALONG)
            )
            for each in motions
            if isinstance(each, PoseTrajectory)
            for along in [_phases(each)]
        ]
    )

    def apart(i: int, others: Indices) -> Float64Array:
        own = np.tile(turned[i], (len(others), 1))
        return rotations.distance(own, turned[others].reshape(-1, 4)).reshape(-1, _ALONG)

    for i, angles in _lone(len(turned), apart, _ROTATED):
        at = int(np.argmax(angles))
        yield (
            i,
            (
                f"is rotated by {np.degrees(angles[at]):.0f} degrees against the nearest other at "
                f"{at / (len(angles) - 1):.0%} of the path"
            ),
        )


def _phases(motion: Motion) -> Float64Array:
    """Increasing numbers (n,) along the path, which rise a little in time as well."""
    covered = arc_length(motion.positions)
    elapsed = motion.times - motion.times[0]
    return np.asarray(covered + max(float(covered[-1]), 1.0) * 1e-3 * elapsed / elapsed[-1])


def _of_other_pace(motions: Sequence[Motion]) -> Iterator[tuple[int, str]]:
    paces = np.array([arc_length(each.positions)[-1] / each.duration for each in motions])
    if len(paces) < 3 or paces.min() <= 0.0:
        return
    for i, pace in enumerate(paces):
        others = np.delete(paces, i)
        if pace > _PACE * others.max():
            yield i, f"is {pace / np.median(others):.2g} times as fast as the others"
        elif pace < others.min() / _PACE:
            yield i, f"is {np.median(others) / pace:.2g} times as slow as the others"


def _lone(
    count: int, apart: Callable[[int, Indices], Float64Array], far: float
) -> Iterator[tuple[int, Float64Array]]:
    """Those far from all others, with the distances from the nearest along the path."""
    if count < 3:
        return
    distances_of = (apart(i, _others(count, i)) for i in range(count))
    rows = [each[int(np.argmin(each.mean(axis=1)))] for each in distances_of]
    means = np.array([each.mean() for each in rows])
    for i, distances in enumerate(rows):
        if means[i] > max(far, _LONE * float(np.delete(means, i).max())):
            yield i, distances
