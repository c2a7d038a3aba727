"""Demonstrations that contradict all others: reversed, of another task, rotated, of another pace.

Only a lone one contradicts: two that agree with each other are a second way of doing the task.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.preprocess import arc_length, by_arc_length
from leadthrough.preprocess.align import features
from leadthrough.preprocess.moved_ends import with_ends

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
    paths = [by_arc_length(each, _ALONG) for each in features(motions, _SAMPLES)]
    found: dict[int, str] = {}
    for index, text in (
        *_reversed(paths),
        *_of_other_paths(paths, motions[0].positions.shape[1]),
        *_rotated(motions),
        *_of_other_pace(motions),
    ):
        found.setdefault(index, text)
    return [Contradiction(index, found[index]) for index in sorted(found)]


def _others(count: int, index: int) -> list[int]:
    """Indices of the other motions; of many, evenly chosen ones."""
    rest = [i for i in range(count) if i != index]
    some = np.linspace(0, len(rest) - 1, min(len(rest), _MAX_OTHERS)).round().astype(int)
    return [rest[i] for i in some]


def _reversed(paths: Sequence[Float64Array]) -> Iterator[tuple[int, str]]:
    for i, path in enumerate(paths):
        if len(paths) < 3 and i == 0:
            continue  # of two, the second
        others = [paths[j] for j in _others(len(paths), i)]
        ahead, back = (
            min(float(np.linalg.norm(each - own, axis=1).mean()) for each in others)
            for own in (path, path[::-1])
        )
        if others and ahead > _FAR and back < _REVERSED * ahead:
            yield i, "runs backwards, from the goal of the others to their start"


def _of_other_paths(paths: Sequence[Float64Array], size: int) -> Iterator[tuple[int, str]]:
    positions = [each[:, :size] for each in paths]

    def apart(i: int, j: int) -> Float64Array:
        """Distances (n,) once both ends are carried to those of the other."""
        carried = with_ends(positions[i], positions[j][0], positions[j][-1])
        return np.asarray(np.linalg.norm(carried - positions[j], axis=1))

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
    turned = [
        rotations.interpolate(along / along[-1], each.orientations, np.linspace(0.0, 1.0, _ALONG))
        for each in motions
        if isinstance(each, PoseTrajectory)
        for along in [_phases(each)]
    ]

    def apart(i: int, j: int) -> Float64Array:
        return np.asarray(rotations.distance(turned[i], turned[j]))

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
    count: int, apart: Callable[[int, int], Float64Array], far: float
) -> Iterator[tuple[int, Float64Array]]:
    """Those far from all others, with the distances from the nearest along the path."""
    if count < 3:
        return
    rows = [
        min((apart(i, j) for j in _others(count, i)), key=lambda each: float(each.mean()))
        for i in range(count)
    ]
    means = np.array([each.mean() for each in rows])
    for i, distances in enumerate(rows):
        if means[i] > max(far, _LONE * float(np.delete(means, i).max())):
            yield i, distances
