"""Warps of time that bring motions into step.

Dynamic time warping (Sakoe and Chiba 1978) brings each motion to the mean timing of all, around a
mean that is warped along with them (Petitjean et al. 2011, "A global averaging method for dynamic
time warping").
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, rotations
from leadthrough.check import Float64Array
from leadthrough.motion import Motion, PoseTrajectory, normalised_times

# Samples at which motions are compared; a path of pairs takes a byte for each pair.
COMPARED = 1000
_ROUNDS = 3
_SMOOTHED = 0.021  # fraction of a warp that is averaged
# A smaller turn counts as if it were this large: what is left of it is mostly noise.
_MIN_TURN = 0.1  # rad
# The Frobenius distance of two rotation matrices is this times their angle, if that is small.
_CHORD = np.sqrt(2.0)


def positions_at(motion: Motion, fractions: Float64Array) -> Float64Array:
    """Positions (n, d) of a motion at fractions (n,) of its duration."""
    own = normalised_times(motion.times)
    return np.column_stack([np.interp(fractions, own, column) for column in motion.positions.T])


def features(motions: Sequence[Motion], samples: int = COMPARED) -> list[Float64Array]:
    """What is compared, (samples, m) at evenly spaced times, in units of the motions' extent."""
    even = np.linspace(0.0, 1.0, samples)
    positions = [positions_at(each, even) for each in motions]
    extent = float(np.mean([np.linalg.norm(np.ptp(each, axis=0)) for each in positions])) or 1.0
    scaled = [each / extent for each in positions]
    turned = [
        rotations.interpolate(normalised_times(each.times), each.orientations, even)
        for each in motions
        if isinstance(each, PoseTrajectory)
    ]
    if not turned:
        return scaled
    reach = np.mean(
        [rotations.distance(each, each[:1].repeat(samples, 0)).max() for each in turned]
    )
    unit = _CHORD * max(float(reach), _MIN_TURN)
    return [
        np.hstack([own, rotations.to_matrix(each).reshape(-1, 9) / unit])
        for own, each in zip(scaled, turned, strict=True)
    ]


def spread(curves: Sequence[Float64Array]) -> float:
    """Root mean square distance of curves (n, m) from their mean."""
    return float(np.sqrt(np.var(curves, axis=0).sum(axis=1).mean()))


def mean_timing(
    curves: Sequence[Float64Array],
    first: Float64Array,
    *,
    rigidity: float,
    rounds: int = _ROUNDS,
) -> list[Float64Array]:
    """For each curve (n, m) its fractions (n,) of the duration at those of the mean timing."""
    even = np.linspace(0.0, 1.0, len(first))
    middle = first
    for _ in range(rounds):
        warps = [warp(middle, each, rigidity=rigidity) for each in curves]
        back = np.interp(even, np.mean(warps, axis=0), even)
        warps = [np.interp(back, even, each) for each in warps]
        middle = np.mean(warped(curves, warps), axis=0)
    return warps


def warp(middle: Float64Array, curve: Float64Array, *, rigidity: float) -> Float64Array:
    """Fractions (n,) of a curve's duration that belong to those of another, end to end."""
    even = np.linspace(0.0, 1.0, len(middle))
    timed = [np.column_stack([each, rigidity * even]) for each in (middle, curve)]
    late = _mean_partner(_core.dtw_path(*timed)) / (len(even) - 1.0) - even
    # Mirrored through both ends, where it is 0, by as much as two averages take away.
    window = round(_SMOOTHED * len(even)) | 1
    late = np.concatenate([-late[window - 1 : 0 : -1], late, -late[-2 : -window - 1 : -1]])
    for _ in range(2):
        late = np.convolve(late, np.full(window, 1.0 / window), mode="valid")
    fractions = np.clip(even + late, 0.0, 1.0)
    fractions[[0, -1]] = 0.0, 1.0
    return np.asarray(np.maximum.accumulate(fractions))


def warped(curves: Sequence[Float64Array], warps: Sequence[Float64Array]) -> list[Float64Array]:
    """Curves (n, m) at fractions (n,) of their durations."""
    even = np.linspace(0.0, 1.0, len(curves[0]))
    return [
        np.column_stack([np.interp(fractions, even, column) for column in curve.T])
        for curve, fractions in zip(curves, warps, strict=True)
    ]


def _mean_partner(pairs: NDArray[np.integer[Any]]) -> Float64Array:
    """For each sample of the first curve the mean index of those paired with it, end to end."""
    first, second = pairs[:, 0], pairs[:, 1]
    partners = np.bincount(first, second) / np.bincount(first)
    partners[[0, -1]] = second[[0, -1]]
    return np.asarray(partners)
