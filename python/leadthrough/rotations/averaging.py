"""Means of rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput

# Within a quarter turn of one point there is only one mean (Afsari 2011); two rotations half a turn
# apart have two. With the margin, rounding does not decide between them.
MAX_REACH = np.pi / 2 - 1e-6  # rad


def mean(quaternions: ArrayLike, *, weights: ArrayLike | None = None) -> Float64Array:
    """The rotation with the least weighted sum of squared distances (Karcher mean).

    Args:
        quaternions: unit quaternions (k, 4), or (k, n, 4) for n means of k rotations each.
        weights: one for each of the k rotations, >= 0, not all 0; equal by default.

    Returns:
        A quaternion (4,), or (n, 4), with the sign of the nearer of the first rotation's two
        quaternions.

    Raises:
        InvalidInput: if rotations of weight > 0 lie a quarter turn or more from their unweighted
            middle, where more than one mean is possible.

    Source: Markley et al. 2007, "Averaging quaternions", for the start; Manton 2004, "A
        globally convergent numerical algorithm for computing the centre of mass on compact Lie
        groups".
    """
    single = _is_one_column(quaternions)
    shape = ("k", 4) if single else ("k", "n", 4)
    layers = check.quaternions(quaternions, "quaternions", shape=shape)
    if len(layers) == 0:
        raise InvalidInput("quaternions: expected at least one rotation, got none")
    factors = _weights(weights, len(layers))
    kept = np.ascontiguousarray(layers[factors > 0]).reshape(-1, 4)
    means, reach = core.so3_mean(kept, factors[factors > 0])
    if (reach > MAX_REACH).any():
        i = int(np.argmax(reach > MAX_REACH))
        where = "" if single else f" in mean {i}"
        raise InvalidInput(
            "quaternions: expected rotations within a quarter turn of their middle, "
            f"got one {np.degrees(reach[i]):.4g} degrees away{where}"
        )
    return means[0] if single else means


def _is_one_column(quaternions: ArrayLike) -> bool:
    try:
        return np.ndim(quaternions) == 2
    except ValueError:  # ragged rows, which the check names
        return False


def _weights(weights: ArrayLike | None, count: int) -> Float64Array:
    if weights is None:
        return np.ones(count)
    factors = check.array(weights, "weights", shape=(count,))
    if (factors < 0).any() or not factors.any():
        raise InvalidInput(f"weights: expected numbers >= 0, not all 0, got {factors}")
    return np.asarray(factors / factors.max())
