"""Keeping a demonstrated timing wherever limits allow: never earlier, no later than needed.

Where the motion is on time, the demonstrated pace is the fastest allowed. Where limits have made it
late, the pace is free until the place at which the motion is on time again. That place is found by
bisection, as the limits also bound how fast the pace changes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array

# A motion counts as late by this fraction of its demonstrated duration; less is not made up for.
_LATE = 5e-3
_MOST_HURRIES = 20
# Places between two attempts, where the motion is late but any faster pace comes early at once.
_APART = 10

Free = NDArray[np.bool_]


def hurries(due: Float64Array, arrival: Callable[[Free], Float64Array], *, slack: float) -> Free:
    """Where along a path the pace is free, so that the motion catches up, (n,)."""
    free = np.zeros(len(due), dtype=np.bool_)
    late = arrival(free) - due
    allowed = min(float(late.min()), 0.0) - slack
    too_late = max(_LATE * float(due[-1] - due[0]), 4.0 * slack)
    begin = 0
    for _ in range(_MOST_HURRIES):
        places = np.flatnonzero(late[begin:] > too_late)
        if not len(places):
            break
        first = begin + int(places[0])
        end = _end(free, first, lambda some: arrival(some) - due, allowed)
        free[first:end] = True
        late = arrival(free) - due
        begin = max(end, first + _APART)
    return free


def _end(free: Free, first: int, lateness: Callable[[Free], Float64Array], allowed: float) -> int:
    """The place up to which the pace may be free from the first one without coming early."""

    def early(end: int) -> bool:
        trial = free.copy()
        trial[first:end] = True
        return bool((lateness(trial)[first:] < allowed).any())

    low, high = first, len(free)
    if not early(high):
        return high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if early(middle) else (middle, high)
    return low
