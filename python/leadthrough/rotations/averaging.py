"""Means of rotations."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Within a quarter turn of one point there is one mean only (Afsari 2011); two rotations half a turn
# apart have two. The margin keeps the choice between them from rounding.
MAX_REACH = np.pi / 2 - 1e-6  # rad


def mean(quaternions: Any, *, weights: Any = None) -> Float64Array:
    """The rotation with the least weighted sum of squared distances (Karcher mean).

    quaternions: (k, 4), the result is (4,), or (k, n, 4), n means of k rotations each, (n, 4).
    weights: (k,) >= 0, not all 0; left out, all are equal. The sign of the result is that of the
    nearer of the first rotation's two quaternions.
    Raises InvalidInput, also where rotations of weight > 0 lie a quarter turn or more from their
    unweighted middle, which leaves more than one mean possible.
    Source: Markley et al. 2007, "Averaging quaternions", for the start; Manton 2004, "A
    globally convergent numerical algorithm for computing the centre of mass on compact Lie groups".
    """
    single = _is_one_column(quaternions)
    shape = ("k", 4) if single else ("k", "n", 4)
    layers = check.quaternions(quaternions, "quaternions", shape=shape)
    if len(layers) == 0:
        raise InvalidInput("quaternions: expected at least one rotation, got none")
    factors = _weights(weights, len(layers))
    kept = np.ascontiguousarray(layers[factors > 0]).reshape(-1, 4)
    means, reach = _core.so3_mean(kept, factors[factors > 0])
    if (reach > MAX_REACH).any():
        i = int(np.argmax(reach > MAX_REACH))
        where = "" if single else f" in mean {i}"
        raise InvalidInput(
            "quaternions: expected rotations within a quarter turn of their middle, "
            f"got one {np.degrees(reach[i]):.4g} degrees away{where}"
        )
    return means[0] if single else means


def _is_one_column(quaternions: Any) -> bool:
    try:
        return np.ndim(quaternions) == 2
    except ValueError:  # ragged rows, which the check names
        return False


def _weights(weights: Any, count: int) -> Float64Array:
    if weights is None:
        return np.ones(count)
    factors = check.array(weights, "weights", shape=(count,))
    if (factors < 0).any() or not factors.any():
        raise InvalidInput(f"weights: expected numbers >= 0, not all 0, got {factors}")
    return np.asarray(factors / factors.max())
