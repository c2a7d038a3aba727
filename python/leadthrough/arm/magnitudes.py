"""Checks of what control loops are given: numbers of a size that an arm can deal with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# m, rad, per s or s^2: beyond every arm, and the squares of products of such numbers are finite.
LARGEST = 1e6
# s.
SHORTEST_INTERVAL, LONGEST_INTERVAL = 1e-6, 10.0


def values(value: ArrayLike, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` as by `check.array`, of magnitudes up to LARGEST."""
    result = check.array(value, name, shape=shape)
    if result.ndim == 1:  # the quick way: single vectors come in a control loop
        largest = max(map(abs, result.tolist()), default=0.0)
    else:
        largest = float(np.abs(result).max(initial=0.0))
    if largest > LARGEST:
        raise InvalidInput(f"{name}: expected magnitudes up to {LARGEST:g}, got {largest:g}")
    return result


def frozen(value: ArrayLike, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """A read-only copy of `value`, checked as by `values`."""
    result = values(value, name, shape=shape).copy()
    result.setflags(write=False)
    return result


def positive(value: float, name: str) -> float:
    """`value` as a number above 0, up to LARGEST."""
    return check.number(value, name, above=0.0, at_most=LARGEST)


def not_negative(value: float, name: str) -> float:
    """`value` as a number from 0 to LARGEST."""
    return check.number(value, name, at_least=0.0, at_most=LARGEST)


def interval(value: float) -> float:
    """`value` as a control loop's interval dt in s."""
    return check.number(value, "dt", at_least=SHORTEST_INTERVAL, at_most=LONGEST_INTERVAL)
