"""Between rotations: slerp, piecewise slerp and squad."""

from __future__ import annotations

from typing import Any

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.rotations.group import pair


def slerp(a: Any, b: Any, fractions: Any) -> Float64Array:
    """Rotations (n, 4) on the shortest turns from a (n, 4) to b (n, 4), at even speed.

    fractions: (n,), from 0 at a to 1 at b. The result is continuous from a, so at 1 it may be -b.
    Of the two ways of exactly half a turn, it takes the one to b with the sign as given.
    Raises InvalidInput. Source: Shoemake 1985, "Animating rotation with quaternion curves".
    """
    first, second = pair(a, b)
    parts = check.array(fractions, "fractions", shape=(len(first),))
    if ((parts < 0) | (parts > 1)).any():
        raise InvalidInput(
            f"fractions: expected numbers from 0 to 1, got {parts.min()} to {parts.max()}"
        )
    return _core.so3_slerp(first, second, parts)
