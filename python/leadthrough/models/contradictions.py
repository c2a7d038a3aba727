"""Demonstrations that contradict all others: reversed, of another task, rotated, of another pace.

Only a lone one contradicts: two that agree with each other are a second way of doing the task.
Joints at another turn are none: an encoder may wrap where they begin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import rotations, sanity
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, Motion, MotionT, PoseTrajectory
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
    return np.asarray(rest[_evenly(len(rest))])


def _evenly(count: int) -> Indices:
    """Indices of all motions; of many, evenly chosen ones."""
    return np.linspace(0, count - 1, min(count, _MAX_OTHERS)).round().astype(int)


def _to_nearest(rows: Float64Array, others: Float64Array, same: Indices) -> Float64Array:
    """Distances (n,) of rows (n, d) from the nearest of others; others[i] is row same[i]."""
    squares, across = (rows**2).sum(axis=1), np.ascontiguousarray(others.T)
    apart = squares[:, None] + (others**2).sum(axis=1) - 2.0 * core.product(rows, across)
    apart[same, np.arange(len(same))] = np.inf
    return np.asarray(np.sqrt(np.maximum(apart.min(axis=1), 0.0)))


def _at_most(paths: Float64Array) -> Float64Array:
    """Upper bounds (n,) of the mean distances of paths (n, m, d) from the nearest other one."""
    rows, some = paths.reshape(len(paths), -1), _evenly(len(paths))
    return np.asarray(_to_nearest(rows, rows[some], some) / np.sqrt(paths.shape[1]))


def _reversed(paths: Float64Array) -> Iterator[tuple[int, str]]:
    ahead_at_most = _at_most(paths)
    halves = np.where(np.arange(_ALONG) < _ALONG / 2, 1.0, -1.0) / _ALONG
    lopsided = np.einsum("n,knd->kd", halves, paths)  # changes sign on the way back
    some = _evenly(len(paths))
    back_at_least = _to_nearest(lopsided, -lopsided[some], some)
    suspect = (ahead_at_most > _FAR) & (back_at_least < _REVERSED * ahead_at_most)
    for i in np.flatnonzero(suspect).tolist():
        if len(paths) < 3 and i == 0:
            continue  # of two, the second
        others = paths[_others(len(paths), i)]
        ahead, back = (
            float(np.linalg.norm(others - own, axis=2).mean(axis=1).min())
            for own in (paths[i], paths[i, ::-1])
        )
        if ahead > _FAR and back < _REVERSED * ahead:
            yield i, "runs backwards, from the goal of the others to their start"


def _of_other_paths(paths: Float64Array, size: int) -> Iterator[tuple[int, str]]:
    positions = paths[:, :, :size]
    # Paths with the same offsets from their chords differ in their ends alone.
    offsets = with_ends(positions, np.zeros((1, size)), np.zeros((1, size)))

    def apart(i: int, others: Indices) -> Float64Array:
        """Distances (others, n) once both ends are carried to those of the others."""
        return np.asarray(np.linalg.norm(offsets[others] - offsets[i], axis=2))

    for i, distances in _lone(len(paths), apart, _FAR, _at_most(offsets)):
        at = int(np.argmax(distances))
        text = (
            f"takes a path of its own, {distances[at]:.0%} of the extent from its nearest "
            f"neighbour at {at / (len(distances) - 1):.0%} of the path"
        )
        yield i, text


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

    following = np.roll(turned, -1, axis=0).reshape(-1, 4)
    beside = rotations.distance(turned.reshape(-1, 4), following).reshape(-1, _ALONG)
    for i, angles in _lone(len(turned), apart, _ROTATED, beside.mean(axis=1)):
        at = int(np.argmax(angles))
        text = (
            f"is rotated by {np.degrees(angles[at]):.0f} degrees against the nearest other at "
            f"{at / (len(angles) - 1):.0%} of the path"
        )
        yield i, text


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
    count: int,
    apart: Callable[[int, Indices], Float64Array],
    far: float,
    at_most: Float64Array,
) -> Iterator[tuple[int, Float64Array]]:
    """Those far from all others, with the distances from the nearest along the path."""
    # `at_most` are upper bounds of the mean distances from the nearest one, quicker to compute.
    if count < 3 or at_most.max() <= far:
        return
    distances_of = (apart(i, _others(count, i)) for i in range(count))
    rows = [each[int(np.argmin(each.mean(axis=1)))] for each in distances_of]
    means = np.array([each.mean() for each in rows])
    for i, distances in enumerate(rows):
        if means[i] > max(far, _LONE * float(np.delete(means, i).max())):
            yield i, distances


def at_one_turn(motions: Sequence[MotionT]) -> list[MotionT]:
    """The motions, joints that are whole turns from those of most others moved to these."""
    several: list[Any] = list(motions)
    if len(several) < 2 or not isinstance(several[0], JointTrajectory):
        return several
    turns = _turns_apart(np.array([each.positions.mean(axis=0) for each in several]))
    for i, j in np.argwhere(turns):
        sanity.warn(
            f"demonstrations[{i}]: {_name(several[i], j)} is {2.0 * np.pi * turns[i, j]:+.4g} rad, "
            "whole turns, from the others and is learned at their turn; leave it out if the joint "
            "has to be where it was"
        )
    moved = zip(several, 2.0 * np.pi * turns, strict=True)
    return [
        replace(each, positions=each.positions - by) if by.any() else each for each, by in moved
    ]


def _turns_apart(middles: Float64Array) -> Float64Array:
    """Whole turns (k, d) of joints from where they are in most of k motions, by their means."""
    turns = sanity.turns(middles - middles[0])
    return np.asarray(turns - [_usual(column) for column in turns.T])


def _usual(turns: Float64Array) -> float:
    """The most frequent of numbers (k,), and of several the least."""
    values, counts = np.unique(turns, return_counts=True)
    return float(values[np.lexsort([np.abs(values), -counts])[0]])


def _name(joints: JointTrajectory, number: int) -> str:
    return joints.joint_names[number] if joints.joint_names else f"joint number {number + 1}"
