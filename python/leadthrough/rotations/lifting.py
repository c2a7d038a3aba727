"""The continuous logarithm of a motion, with its turns counted."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import NoContinuousLogarithm


def lift(quaternions: Any, *, anchor: Literal["start", "goal"] = "start") -> Float64Array:
    """Rotation vectors (n, 3) of a motion (n, 4), rad, continuous and of any length.

    The vector at the anchor, the first row or the last, is at most pi long; every other one
    continues its neighbour, along the shortest turn between the two rows. Neighbours must lie less
    than half a turn apart.
    On the spheres of whole turns, ||phi|| = 2 pi n with n >= 1, all vectors are the identity: a
    motion about a fixed axis passes them, and so does one whose axis turns only as the vector's
    does. Any other one, noise among them, comes past beside them, where the vector swings about
    while the tool hardly turns. There no continuous logarithm exists that says anything about the
    motion: a step of more than ten times the angle turned raises NoContinuousLogarithm, with the
    row as `index`.
    Raises InvalidInput, NoContinuousLogarithm. Source: Lauretti et al. 2023, eq. 9, with
    v_k = v_(k-1) (1 - 2 k pi / ||v_(k-1) phi||) and v_0 = 1.
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
