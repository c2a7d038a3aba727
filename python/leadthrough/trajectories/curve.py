"""What all curves have in common: a domain, knots, and derivatives at any times inside it."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Times computed by adding steps miss the end of a domain by rounding: this share of its length.
_SLACK = 1e-9


@runtime_checkable
class Curve(Protocol):
    """A curve in d dimensions over an interval of times."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""

    @property
    def knots(self) -> Float64Array:
        """(k,) rising times between which the curve is smooth, the ends of the domain included."""

    def evaluate(self, t: Any, derivative: int = 0) -> Float64Array:
        """Values, or derivatives of an order, (n, d) at times (n,) and (d,) at one time.

        Raises InvalidInput, for times outside the domain too.
        """


def times_inside(t: Any, domain: tuple[float, float]) -> Float64Array:
    """`t` as times of the domain, (n,) or of no dimension; rounding beyond its ends is cut."""
    times = check.array(t, "t", shape=() if np.ndim(t) == 0 else ("n",))
    first, last = domain
    if not times.size or (first <= times.min() and times.max() <= last):
        return times
    slack = _SLACK * (last - first)
    wrong = times[(times < first - slack) | (times > last + slack)]
    if wrong.size:
        raise InvalidInput(
            f"t: expected times from {first:.6g} to {last:.6g}, got {wrong.flat[0]:.6g}"
        )
    return np.clip(times, first, last)


def order(derivative: Any) -> int:
    """`derivative` as the order of a derivative."""
    return check.integer(derivative, "derivative", at_least=0)


def knot_times(value: Any, name: str) -> Float64Array:
    """At least two strictly increasing times, (n,), read-only."""
    knots = check.times(value, name)
    if len(knots) < 2:
        raise InvalidInput(f"{name}: expected at least two, got one")
    return knots


def points(value: Any, name: str, *, count: int | None = None, least: int = 1) -> Float64Array:
    """Points (n, d), read-only; (n,) are points in one dimension."""
    rows = np.ndim(value) == 1
    try:
        table = np.reshape(value, (-1, 1)) if rows else value
    except (TypeError, ValueError):
        table = value
    result = check.frozen(table, name, shape=("n" if count is None else count, "d"))
    if len(result) < least or result.shape[1] == 0:
        raise InvalidInput(
            f"{name}: expected at least {least} points of one dimension or more, "
            f"got shape {result.shape}"
        )
    return result
