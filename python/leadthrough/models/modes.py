"""Modes and common phases of demonstrations, which models find before they average any.

Demonstrations of one mode that are misaligned in time pass the same part of the path at the same
phase: clocks stop during rests where most others pass by, and elastic alignment takes further
differences in timing out. Aligned phases advance with the median pace, so that a pause of one
demonstration is none of the motion, and one of all is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np

from leadthrough import rotations
from leadthrough.check import FitError, Float64Array
from leadthrough.models.archive import FittedSkill
from leadthrough.models.coordinates import NODES, groups_of, mean_orientations
from leadthrough.models.curves import Curves, by_arc, elastic, even_phases, features_of, modes_of
from leadthrough.models.protocol import Demonstrations, Outliers, motions_of
from leadthrough.motion import Motion, MotionT, PoseTrajectory, Trajectory, normalised_times, thin
from leadthrough.preprocess.align import lateness
from leadthrough.rest import long_rests

# Fraction of the phase that advances with the demonstration's own time, so that it never stops.
_ADVANCING = 1e-3
# How long motions stay at a place counts so far around it, in phases of the common path.
_NEAR = 0.08
MAX_ROWS = 10_000  # of a demonstration: ten for each of the most weights
_MIN_COUNT = 3  # motions, of which two can agree
_AGREEING = 2  # motions that are rotated alike are a mode; a lone one is refused

_Fitted = TypeVar("_Fitted", bound=FittedSkill)


def learned_by_mode(
    fit: Callable[[Sequence[MotionT]], _Fitted],
    demonstrations: Demonstrations[MotionT],
    outliers: Outliers,
    rows: int = MAX_ROWS,
) -> _Fitted:
    """The skill of the most demonstrated mode, which knows those of the others."""
    motions = [thin(each, rows) for each in motions_of(demonstrations, outliers=outliers)]
    skills = [fit(each) for each in by_mode(motions, drop_lone=outliers == "drop")]
    return skills[0].with_modes(skills)


def by_mode(motions: Sequence[MotionT], *, drop_lone: bool = False) -> list[list[MotionT]]:
    """The motions of each mode, that of the most motions first."""
    if len(motions) < _MIN_COUNT:
        return [list(motions)]
    numbers = modes_of(_curves_of(tuple(motions)).rows)
    groups = [np.flatnonzero(numbers == number) for number in range(numbers.max() + 1)]
    parts = [
        part
        for group in groups
        for part in _with_a_mean([motions[int(i)] for i in group], drop_lone)
    ]
    return sorted(parts, key=len, reverse=True)


def _with_a_mean(motions: list[MotionT], drop_lone: bool) -> list[list[MotionT]]:
    """Motions of one path, in two parts where each has mean orientations and all have none."""
    layers = [
        rotations.interpolate(u, each.orientations, NODES)
        for u, each in zip(common_phases(motions), motions, strict=True)
        if isinstance(each, PoseTrajectory)
    ]
    try:
        if layers:
            mean_orientations(layers)
    except FitError:
        parts = [part for part in groups_of(layers)[:2] if len(part) >= _AGREEING]
        if len(parts) == 2 or (parts and drop_lone):
            return [[motions[i] for i in part] for part in parts]
    return [motions]


def common_phases(motions: Sequence[Motion]) -> list[Float64Array]:
    """Phases (n,) of the samples of each motion, from 0 to 1, equal along their common path."""
    return list(_phases_of(tuple(motions)))


@lru_cache(maxsize=9)  # families are fitted to the same motions: all, or one of eight left out
def _curves_of(motions: tuple[Motion, ...]) -> Curves:
    """The motions by arc length, with normalised times."""
    return by_arc(features_of(motions), [normalised_times(each.times) for each in motions])


@lru_cache(maxsize=9)
def _phases_of(motions: tuple[Motion, ...]) -> tuple[Float64Array, ...]:
    motions = _without_lone_rests(motions)
    own = [normalised_times(each.times) for each in motions]
    if not lateness(motions).any():
        return tuple(own)
    aligned = elastic(_curves_of(motions)).times
    pace = np.median(np.diff(aligned, axis=1), axis=0)
    clock = np.concatenate([[0.0], np.cumsum(pace / pace.sum())])
    even = even_phases(len(clock))
    return tuple(
        _advancing(np.interp(np.interp(u, each, even), even, clock), u)
        for u, each in zip(own, aligned, strict=True)
    )


def _without_lone_rests(motions: tuple[Motion, ...]) -> tuple[Motion, ...]:
    """The motions on clocks that stop during rests where most others pass by."""
    found = [long_rests(each) for each in motions] if len(motions) > 1 else []
    if not any(found):
        return motions
    spans = np.array([each.times[[0, -1]] for each in motions])
    times = spans[:, :1] + elastic(_curves_of(motions)).times * np.diff(spans)
    return tuple(
        _clocked(each, [rest for rest in rests if _lone(rest, i, times)])
        for i, (each, rests) in enumerate(zip(motions, found, strict=True))
    )


def _lone(rest: tuple[float, float], which: int, times: Float64Array) -> bool:
    """Whether most others pass by a rest (2,) of one motion; at times (k, n) on their way."""
    even = even_phases(times.shape[1])
    around = np.add(np.interp(rest, times[which], even), (-_NEAR, _NEAR))
    stays = np.array([np.ptp(np.interp(around, even, each)) for each in times])
    other = float(np.median(np.delete(stays, which)))
    # At a turn all are slow, and a few may count as at rest.
    return bool(stays[which] - 0.5 * np.ptp(rest) > other)


def _clocked(motion: Motion, rests: Sequence[tuple[float, float]]) -> Motion:
    """The shape of a motion on a clock that almost stops during rests."""
    if not rests:
        return motion
    clock = motion.times - motion.times[0]
    for start, end in rests:
        clock = clock - np.clip(motion.times - start, 0.0, end - start)
    clock = _advancing(clock / clock[-1], normalised_times(motion.times))
    if isinstance(motion, PoseTrajectory):
        return PoseTrajectory(clock, motion.positions, motion.orientations)
    return Trajectory(clock, motion.positions)


def _advancing(phases: Float64Array, own: Float64Array) -> Float64Array:
    """Phases (n,) from 0 to 1 that rise with the normalised times (n,) wherever they rested."""
    rising = (1.0 - _ADVANCING) * phases + _ADVANCING * own
    rising[[0, -1]] = 0.0, 1.0
    return rising
