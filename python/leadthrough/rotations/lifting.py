"""The continuous logarithm of a motion, with its turns counted."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import NoContinuousLogarithm


def lift(quaternions: ArrayLike, *, anchor: Literal["start", "goal"] = "start") -> Float64Array:
    """Rotation vectors (n, 3) of a motion, rad, continuous and of any length.

    On the spheres of whole turns, ||phi|| = 2 pi n with n >= 1, every vector is the identity: a
    motion about a fixed axis passes through them, and so does one whose axis turns only as the
    vector's does. Any other motion, a noisy one included, passes beside them, where the vector
    swings about while the tool hardly turns. No continuous logarithm that tells anything about the
    motion exists there.

    Args:
        quaternions: unit quaternions (n, 4), neighbours less than half a turn apart.
        anchor: the row, first or last, whose vector is at most pi long; every other vector
            continues its neighbour's along the shortest turn between the two rows.

    Raises:
        InvalidInput: if they are not unit quaternions of that shape.
        NoContinuousLogarithm: if neighbours are half a turn apart, or the vector steps by more than
            ten times the angle turned; with the row as `index`.

    Source: Lauretti et al. 2023, eq. 9, with v_k = v_(k-1) (1 - 2 k pi / ||v_(k-1) phi||) and
        v_0 = 1.
    """
    q = check.quaternions(quaternions, "quaternions", shape=("n", 4))
    backward = check.choice(anchor, "anchor", ("start", "goal")) == "goal"
    vectors, broken = _core.so3_lift(np.ascontiguousarray(q[::-1]) if backward else q)
    if broken >= 0:
        index, before = (len(q) - 1 - broken, len(q) - broken) if backward else (broken, broken - 1)
        turn = np.degrees(_core.so3_distance(q[[before]], q[[index]])[0])
        raise NoContinuousLogarithm(
            f"quaternions: no rotation vector of sample {index} continues that of sample {before}, "
            f"{turn:.4g} degrees away (half a turn, or beside a whole number of turns)",
            index=index,
        )
    return np.ascontiguousarray(vectors[::-1]) if backward else vectors
