"""Checks of a control loop's arguments: numbers of a size that an arm can handle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput

# m, rad, per s or s^2: beyond every arm, and the squares of products of such numbers are finite.
_MAX = 1e6
# s.
_MIN_INTERVAL, _MAX_INTERVAL = 1e-6, 10.0


def values(value: ArrayLike, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` as by `check.array`, of magnitudes up to _MAX."""
    result = check.array(value, name, shape=shape)
    if result.ndim == 1:  # the fast path: single vectors come in a control loop
        largest = max(map(abs, result.tolist()), default=0.0)
    else:
        largest = float(np.abs(result).max(initial=0.0))
    if largest > _MAX:
        raise InvalidInput(f"{name}: expected magnitudes up to {_MAX:g}, got {largest:g}")
    return result


def frozen(value: ArrayLike, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    return check.freeze(values(value, name, shape=shape).copy())


def positive(value: float, name: str) -> float:
    """`value` as a number above 0, up to _MAX."""
    return check.number(value, name, above=0.0, at_most=_MAX)


def not_negative(value: float, name: str) -> float:
    """`value` as a number from 0 to _MAX."""
    return check.number(value, name, at_least=0.0, at_most=_MAX)


def interval(value: float) -> float:
    """`value` as a control loop's interval dt in s."""
    return check.number(value, "dt", at_least=_MIN_INTERVAL, at_most=_MAX_INTERVAL)
