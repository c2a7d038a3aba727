"""The mean orientations of motions, for every model that averages them.

Rotations have one mean where all lie within a quarter turn of a middle (Afsari 2011, "Riemannian
L^p center of mass"). Elsewhere any choice, such as the first demonstration, would be arbitrary.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import rotations
from leadthrough.check import FitError, Float64Array, InvalidInput
from leadthrough.preprocess.align import frechet_distance

# For a middle without a quarter turn around it: how much more the rotations must agree on it than
# on any other, as a fraction, and how far off it one may be, short of the half turn of its
# antipode, where rotation vectors jump.
_AGREED = 0.25
_MAX_DISTANCE = np.radians(150.0)
# Within a quarter turn, a mean rotates at most 4 / pi times as fast as the rotations do. More than
# that is a jump from one side to the other, between two samples that both have a mean.
_MAX_SPEEDUP = 1.5
_ROUNDING = 1e-6  # rad
# Nearer than a quarter turn throughout, once warped in time: the same rotation at other times.
_ALIKE = np.pi / 2  # rad
# The Frobenius distance of two rotation matrices is this times the sine of half their angle.
_CHORD = 2.0 * np.sqrt(2.0)


def mean_orientations(
    layers: Sequence[Float64Array], *, weights: Float64Array | None = None
) -> Float64Array:
    """The mean orientations of several motions; they do not depend on their order."""
    stacked = np.stack(layers)
    try:
        means = rotations.mean(stacked, weights=weights)
    except InvalidInput:
        raise FitError(_disagreement(stacked)) from None
    if _jumps(means, stacked):
        raise FitError(_disagreement(stacked))
    return rotations.align_signs(means)


def middle_orientations(layers: Sequence[Float64Array]) -> Float64Array:
    """Middle orientations of several motions; they do not depend on their order.

    Source: Markley et al. 2007, "Averaging quaternions".
    """
    try:
        return mean_orientations(layers)
    except FitError:
        stacked = np.stack(layers)
        moments = np.einsum("kni,knj->nij", stacked, stacked) / len(stacked)
        values, vectors = np.linalg.eigh(moments)
        middles = rotations.align_signs(vectors[:, :, -1])
        off = max(float(rotations.distance(each, middles).max()) for each in stacked)
        divided = float((values[:, -1] - values[:, -2]).min()) < _AGREED
        if divided or off > _MAX_DISTANCE or _jumps(middles, stacked):
            raise
        return middles


def _jumps(means: Float64Array, stacked: Float64Array) -> bool:
    """Whether means (n, 4) rotate faster than rotations (k, n, 4) that they are means of."""
    jumps = rotations.distance(means[1:], means[:-1])
    steps = [rotations.distance(layer[1:], layer[:-1]) for layer in stacked]
    return bool((jumps > _MAX_SPEEDUP * np.max(steps, axis=0) + _ROUNDING).any())


def groups_of(layers: Sequence[Float64Array]) -> tuple[list[int], list[int], int, float]:
    """Two groups of demonstrations, each around one of the two that come to lie farthest apart."""
    stacked = np.stack(layers)
    count = len(stacked)
    apart = np.zeros((count, count, stacked.shape[1]))
    for i in range(count):
        for j in range(i):
            apart[i, j] = apart[j, i] = rotations.distance(stacked[i], stacked[j])
    one, other, at = np.unravel_index(int(np.argmax(apart)), apart.shape)
    nearer = apart[one, :, at] <= apart[other, :, at]
    near = [i for i in range(count) if nearer[i] == nearer[0]]
    far = [i for i in range(count) if nearer[i] != nearer[0]]
    return near, far, int(at), float(apart[one, other, at])


def _disagreement(stacked: Float64Array) -> str:
    """The message about demonstrations without mean orientations, with the remedy."""
    near, far, at, angle = groups_of(list(stacked))
    fraction = at / max(stacked.shape[1] - 1, 1)
    text = (
        f"demonstrations: no mean orientation: at {fraction:.0%} of the motion, demonstrations "
        f"{near} and {far} turn up to {np.degrees(angle):.0f} degrees apart; "
    )
    if all(_same_rotation(stacked[near[0]], stacked[i]) for i in far):
        return text + (
            "they turn alike, but at different times: leave one out, or bring them into step with "
            "preprocess.align_by_time_warping"
        )
    return text + "fit each group alone, or leave one out"


def _same_rotation(one: Float64Array, other: Float64Array) -> bool:
    """Whether two series of orientations (n, 4) are near each other once one is warped in time."""
    chord = frechet_distance(*(rotations.to_matrix(each).reshape(-1, 9) for each in (one, other)))
    return 2.0 * float(np.arcsin(min(chord / _CHORD, 1.0))) < _ALIKE
