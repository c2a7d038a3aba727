"""A path that comes near itself, cut into pieces that do not.

A speed map over space cannot tell the first pass through a place from the second, so a wave takes
the short cut from one to the other wherever that is quicker than the way along the tube. Between
two cuts there is none to take. Unlike a domain lifted by the phase, pieces need no further
dimension and lose no accuracy.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.preprocess.resample import arc_length, by_arc_length

_SAMPLES_PER_RADIUS = 4.0
_MOST_SAMPLES = 2000
# Half a circle of the radius is the tightest turn that its tube still resolves.
_SAME_PASS = np.pi
# Cut also where the short cut is only nearly quicker: the wave bends towards it.
_CAUTION = 1.5


def cut_at_short_cuts(
    path: Float64Array, *, radius: float, saturation: float
) -> list[Float64Array]:
    """Consecutive pieces of a path in whose tubes no short cut is quicker than the way.

    Args:
        path: (n, d).
        radius: of the tube.
        saturation: speed one radius away from the path; in between it falls linearly from 1.

    Returns:
        Pieces of which neighbours share their end point; one where the path does not come near
        itself.
    """
    wanted = _SAMPLES_PER_RADIUS * float(arc_length(path)[-1]) / radius
    even = by_arc_length(path, int(min(max(np.ceil(wanted), 1), _MOST_SAMPLES)) + 1)
    quicker = _short_cuts(even, radius, saturation)
    cuts = [0]
    while (end := _first_short_cut(quicker, cuts[-1])) < len(even) - 1:
        cuts.append(end)
    cuts.append(len(even) - 1)
    if len(cuts) == 2:
        return [path]
    return [even[a : b + 1] for a, b in pairwise(cuts)]


def _short_cuts(even: Float64Array, radius: float, saturation: float) -> NDArray[np.bool_]:
    """Whether going straight from sample i to j is quicker than along the path, (n, n)."""
    along = arc_length(even)
    way = np.abs(along[:, None] - along[None])
    distance = np.linalg.norm(even[:, None] - even[None], axis=2)
    quicker = _CAUTION * way > _time(distance, radius, saturation)
    return np.asarray(quicker & (way > _SAME_PASS * radius))


def _time(distance: Float64Array, radius: float, saturation: float) -> Float64Array:
    """Times straight from the middle of one tube to the middle of another: out, across, in."""
    out = np.minimum(0.5 * distance, radius)
    slope = (1.0 - saturation) / radius
    flank = -np.log1p(-slope * out) / slope if slope > 0.0 else out
    return np.asarray(2.0 * flank + np.maximum(distance - 2.0 * radius, 0.0) / saturation)


def _first_short_cut(quicker: NDArray[np.bool_], begin: int) -> int:
    """The last sample up to which a piece from `begin` on has no short cut."""
    piece = np.tril(quicker[begin:, begin:])
    found = np.flatnonzero(piece.any(axis=1))
    return begin + int(found[0]) - 1 if len(found) else len(quicker) - 1
