"""Which demonstrations can be trusted to tell the way between a start and a goal.

Those whose ends lie near. Where they lie only nearly so, they have to go the way of another one:
one that resembles none of the others may have its ends there by accident.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length, by_arc_length

# A mean path is trusted where a demonstration's ends are nearer to start and goal than this
# fraction of the distance between these, or, for motions that return, of its own length. Farther
# off the demonstrations say little about the way, and bending them to it gives detours.
_NEAR_OF_DISTANCE = 0.5
_NEAR_OF_LENGTH = 0.1
_NEAR_OF_EXTENT = 0.5
# One of several that resembles none of the others has to come nearer, by this fraction, if it
# returns. If it is so many times as long as its extent, it strays, and has to begin and end there.
_VERY_NEAR = 0.3
_STRAYING = 3.0
_AT_ITS_ENDS = 0.03  # of its extent
# Demonstrations resemble each other where the root mean square distance between them, their ends
# laid on each other, is below this fraction of the length, or of three extents, of either; and, if
# one of them is curved, below this fraction of the distance of either from its own chord.
_COMPANY, _USUAL = 0.05, 3.0
_ALIKE = 0.5
STRAIGHT = 0.5  # least chord, over the length, of a demonstration that is not curved
_SAMPLES = 100


def is_trusted(paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array) -> bool:
    """Whether a demonstration's ends lie near enough to start and goal to predict the way."""
    near, nearly = _nearness(paths, start, goal)
    return bool(near.any() or (nearly.any() and (nearly & in_company(paths)).any()))


def trusted(
    paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array
) -> NDArray[np.bool_]:
    """Which demonstrations' ends lie near enough to start and goal, (k,), as by `is_trusted`."""
    near, nearly = _nearness(paths, start, goal)
    return near | (nearly & in_company(paths))


def in_company(paths: Sequence[Float64Array]) -> NDArray[np.bool_]:
    """Which demonstrations (k,) go the way of another, so that it is no accident, or are alone."""
    if len(paths) == 1:
        return np.ones(1, dtype=bool)
    curves = np.stack([by_arc_length(path, _SAMPLES) for path in paths])
    lengths = np.array([arc_length(curve)[-1] for curve in curves])
    extents = np.linalg.norm(np.ptp(curves, axis=1), axis=1)
    u = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    bent = curves - (1.0 - u) * curves[:, :1] - u * curves[:, -1:]
    apart = _rms(bent[:, None] - bent[None])
    chords = np.linalg.norm(curves[:, -1] - curves[:, 0], axis=1)
    straight = chords >= STRAIGHT * lengths
    alike = apart < _COMPANY * _of_either(np.minimum(lengths, _USUAL * extents))
    alike &= (straight[:, None] & straight[None]) | (apart < _ALIKE * _of_either(_rms(bent)))
    np.fill_diagonal(alike, val=False)
    return np.asarray(alike.any(axis=1))


def _rms(offsets: Float64Array) -> Float64Array:
    """Root mean squares (...) of the lengths of offsets (..., n, d)."""
    return np.asarray(np.sqrt((offsets**2).sum(axis=-1).mean(axis=-1)))


def _of_either(sizes: Float64Array) -> Float64Array:
    """The smaller one (k, k) of two of the sizes (k,)."""
    return np.minimum(sizes[:, None], sizes[None])


def _nearness(
    paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which paths' ends are near to start and goal, and which are if the path is no accident."""
    distance = float(np.linalg.norm(goal - start))
    ends = np.stack([start, goal])
    gaps = np.array([np.linalg.norm(path[[0, -1]] - ends, axis=1).max() for path in paths])
    lengths = np.array([arc_length(path)[-1] for path in paths])
    extents = np.array([np.linalg.norm(np.ptp(path, axis=0)) for path in paths])
    close = np.minimum(_NEAR_OF_LENGTH * lengths, _NEAR_OF_EXTENT * extents)
    closer = np.maximum(_NEAR_OF_DISTANCE * distance, _VERY_NEAR * close)
    straying = (lengths > _STRAYING * extents) & (len(paths) > 1)
    near = gaps <= np.where(straying, _AT_ITS_ENDS * extents, closer)
    return near, gaps <= np.maximum(_NEAR_OF_DISTANCE * distance, close)
