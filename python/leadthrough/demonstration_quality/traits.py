"""Traits in which a demonstration may differ: its shape, timing, tremor and pauses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import Motion
from leadthrough.preprocess import arc_length, by_arc_length
from leadthrough.preprocess.align import features

Trait = Literal["shape", "timing", "jerk", "stall"]
TRAITS: tuple[Trait, ...] = get_args(Trait)

_SAMPLES = 200
_WINDOW = 11  # samples, of a twentieth of the duration: quicker movements are tremor
_ALONG = 100  # points of a path at which shapes are compared
_STILL = 0.1  # of the mean speed: slower is a rest
# Usual differences of demonstrations of one task: of shapes in extents, of timing in durations, of
# tremor in powers of ten, of rests in durations.
_USUAL: dict[Trait, float] = {"shape": 0.03, "timing": 0.05, "jerk": 0.12, "stall": 0.03}
_SHARED = 0.5  # of the distance from the middle path: nearer than this is the same path
_MIN_TREMOR = 1e-4  # of the extent


def peculiarities(motions: Sequence[Motion]) -> dict[Trait, Float64Array]:
    """Difference (m,) of each motion from the others by trait, in usual differences."""
    curves = features(motions, _SAMPLES)
    smooth = [_smoothed(curve) for curve in curves]
    values: dict[Trait, Float64Array] = {
        "shape": _unlike([_carried(by_arc_length(curve, _ALONG), smooth) for curve in smooth]),
        "timing": _unlike([_progress(curve)[:, None] for curve in smooth], largest=True),
        "jerk": np.array([_tremor(*pair) for pair in zip(curves, smooth, strict=True)]),
        "stall": np.array([_longest_stall(curve) for curve in curves]),
    }
    return {trait: _z_scores(each, _USUAL[trait]) for trait, each in values.items()}


def _smoothed(curve: Float64Array) -> Float64Array:
    """Means of neighbours; near the ends of fewer."""
    sums = np.cumsum(np.vstack([np.zeros_like(curve[:1]), curve]), axis=0)
    at = np.arange(len(curve))
    half = np.minimum(_WINDOW // 2, np.minimum(at, len(curve) - 1 - at))
    smooth: Float64Array = (sums[at + half + 1] - sums[at - half]) / (2 * half + 1)[:, None]
    return smooth


def _tremor(curve: Float64Array, smooth: Float64Array) -> float:
    rough = float(np.sqrt(((curve - smooth) ** 2).sum(axis=1).mean()))
    return float(np.log10(max(rough, _MIN_TREMOR)))


def _longest_stall(curve: Float64Array) -> float:
    """The longest rest between the ends, as a fraction of the duration."""
    speeds = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    still = np.concatenate([[False], speeds < _STILL * speeds.mean(), [False]])
    edges = np.flatnonzero(np.diff(still.astype(int)))
    spans = [(a, b) for a, b in edges.reshape(-1, 2) if a > 0 and b < len(speeds)]
    return max((b - a for a, b in spans), default=0) / len(speeds)


def _progress(curve: Float64Array) -> Float64Array:
    lengths = arc_length(curve)
    return lengths / max(float(lengths[-1]), np.finfo(float).tiny)


def _carried(path: Float64Array, others: Sequence[Float64Array]) -> Float64Array:
    """A path whose ends are moved to the middle of all ends, the rest in proportion."""
    first = np.median([each[0] for each in others], axis=0)
    last = np.median([each[-1] for each in others], axis=0)
    rise = np.linspace(0.0, 1.0, len(path))[:, None]
    carried: Float64Array = path + (1.0 - rise) * (first - path[0]) + rise * (last - path[-1])
    return carried


def _unlike(curves: Sequence[Float64Array], *, largest: bool = False) -> Float64Array:
    """The mean, or largest, distance of each curve from the middle one of the others."""
    every = np.array(curves)
    return np.array(
        [
            (np.max if largest else np.mean)(
                np.linalg.norm(curve - np.median(np.delete(every, i, axis=0), axis=0), axis=1)
            )
            for i, curve in enumerate(every)
        ]
    )


def _z_scores(values: Float64Array, usual: float) -> Float64Array:
    """Robust z-scores: offset from the others' median over their scaled MAD."""
    apart = np.empty(len(values))
    for i, value in enumerate(values):
        others = np.delete(values, i)
        middle = np.median(others)
        spread = 1.4826 * np.median(np.abs(others - middle))
        apart[i] = (value - middle) / max(float(spread), usual)
    return apart


def shares_its_path(motions: Sequence[Motion], index: int) -> bool:
    """Whether a motion's path is that of another, much rather than the middle one of all others."""
    smooth = [_smoothed(curve) for curve in features(motions, _SAMPLES)]
    paths = np.array([_carried(by_arc_length(curve, _ALONG), smooth) for curve in smooth])
    others = np.delete(paths, index, axis=0)
    apart = np.linalg.norm(others - paths[index], axis=2).mean(axis=1)
    middle = np.linalg.norm(np.median(others, axis=0) - paths[index], axis=1).mean()
    return bool(apart.min() < _SHARED * middle)
