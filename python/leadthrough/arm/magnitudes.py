"""Checks of what control loops are given: numbers that an arm can have to do with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# m, rad, per s or s^2: beyond every arm, and the squares of products of such numbers are finite.
LARGEST = 1e6
# s.
SHORTEST_INTERVAL, LONGEST_INTERVAL = 1e-6, 10.0


def values(value: Any, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` as by `check.array`, of magnitudes up to LARGEST. Raises InvalidInput."""
    result = check.array(value, name, shape=shape)
    largest = np.abs(result).max(initial=0.0)
    if largest > LARGEST:
        raise InvalidInput(f"{name}: expected magnitudes up to {LARGEST:g}, got {largest:g}")
    return result


def frozen(value: Any, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """A read-only copy of `value`, checked as by `values`."""
    return check.frozen(values(value, name, shape=shape), name, shape=shape)


def positive(value: Any, name: str) -> float:
    """`value` as a number above 0, up to LARGEST. Raises InvalidInput."""
    return check.number(value, name, above=0.0, at_most=LARGEST)


def not_negative(value: Any, name: str) -> float:
    """`value` as a number from 0 to LARGEST. Raises InvalidInput."""
    return check.number(value, name, at_least=0.0, at_most=LARGEST)


def interval(value: Any) -> float:
    """`value` as a control loop's interval dt, s. Raises InvalidInput."""
    return check.number(value, "dt", at_least=SHORTEST_INTERVAL, at_most=LONGEST_INTERVAL)
