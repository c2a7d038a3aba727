"""Curves: a domain, knots, and derivatives at any times inside it; and those of polynomials."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr

# Times computed by adding steps miss the end of a domain by rounding: this fraction of its length.
_SLACK = 1e-9
# Times that are evaluated together: more would take memory by times and points, and leave Ctrl-C
# waiting.
_BLOCK = 16_384


@runtime_checkable
class Curve(Protocol):
    """A curve in d dimensions over an interval of times."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""

    @property
    def knots(self) -> Float64Array:
        """Rising times (k,) between which the curve is smooth, the ends of the domain included."""

    def evaluate(self, t: ArrayLike, derivative: int = 0) -> Float64Array:
        """Values or derivatives of the curve.

        Args:
            t: times (n,) of the domain, for a result (n, d); or one, for a result (d,).
            derivative: 0 for values, k for derivatives of order k.
        """


class PointCurve(ShortRepr, ABC):
    """A `Curve` of points that can be transformed and slowed down."""

    if TYPE_CHECKING:  # some curves have fields of these names, which properties would hide

        @property
        def domain(self) -> tuple[float, float]:
            """First and last time."""

        @property
        def knots(self) -> Float64Array:
            """Rising times (k,) between which the curve is smooth, the domain's ends included."""

    @abstractmethod
    def _values(self, times: Float64Array, order: int) -> Float64Array:
        """Derivatives of an order at checked times, (n,) or of no dimension."""

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> Self:
        """The curve of matrix @ x + offset, by default with the control points mapped."""
        values: Any = self  # a dataclass with points (n, d)
        mapped: Self = replace(values, points=values.points @ matrix.T + offset)
        return mapped

    @abstractmethod
    def _stretched(self, factor: float) -> Self:
        """The curve passed `factor` times as slowly."""

    def evaluate(self, t: ArrayLike, derivative: int = 0) -> Float64Array:
        """Values or derivatives (n, d) at times (n,), or (d,) at one time.

        Args:
            t: times of the domain, (n,) or one.
            derivative: order of the derivative, 0 for values.
        """
        times, k = times_inside(t, self.domain), order(derivative)
        return in_blocks(lambda block: self._values(block, k), times)

    def transformed(self, matrix: ArrayLike, offset: ArrayLike = 0.0) -> Self:
        """The curve of matrix @ x + offset for every x of this one.

        Args:
            matrix: (e, d).
            offset: (e,) or one number.
        """
        width = len(self.evaluate(self.domain[0]))
        a = check.array(matrix, "matrix", shape=("e", width))
        return self._mapped(a, check.row(offset, "offset", width=len(a)))

    def rescaled(self, factor: float) -> Self:
        """The same path, passed `factor` times as slowly: derivative k is divided by factor**k.

        Args:
            factor: > 0; the times of the domain and the knots are multiplied by it.
        """
        return self._stretched(check.number(factor, "factor", above=0.0))


def times_inside(t: ArrayLike, domain: tuple[float, float]) -> Float64Array:
    """`t` as times of the domain, (n,) or of no dimension; rounding beyond its ends is clipped."""
    times = check.array_of_rank(t, "t", shapes=((), ("n",)))
    first, last = domain
    if not times.size or (first <= times.min() and times.max() <= last):
        return times
    slack = _SLACK * (last - first)
    wrong = times[(times < first - slack) | (times > last + slack)]
    if wrong.size:
        raise check.refused("t", f"times from {first:.6g} to {last:.6g}", f"{wrong.flat[0]:.6g}")
    return np.clip(times, first, last)


def in_blocks(values: Callable[[Float64Array], Float64Array], times: Float64Array) -> Float64Array:
    """Values at times (n,) or at one, some thousand times after the others."""
    if times.size <= _BLOCK:
        return values(times)
    return np.concatenate([values(times[i : i + _BLOCK]) for i in range(0, len(times), _BLOCK)])


def order(derivative: int) -> int:
    return check.integer(derivative, "derivative", at_least=0)


def knot_times(value: ArrayLike, name: str) -> Float64Array:
    """At least two strictly increasing times, (n,), read-only."""
    knots = check.times(value, name)
    if len(knots) < 2:
        raise InvalidInput(f"{name}: expected at least two times, got one")
    return knots


def points(
    value: ArrayLike, name: str, *, count: int | None = None, least: int = 1
) -> Float64Array:
    """Points (n, d), read-only; (n,) are points in one dimension."""
    rows = check.rank(value) == 1
    try:
        table = np.reshape(value, (-1, 1)) if rows else value
    except (TypeError, ValueError):
        table = value
    result = check.frozen(table, name, shape=("n" if count is None else count, "d"))
    if len(result) < least or result.shape[1] == 0:
        raise check.refused(
            name, f"at least {least} points of one dimension or more", f"shape {result.shape}"
        )
    return result


@dataclass(frozen=True, eq=False, init=False)
class Spline(PointCurve):
    """Polynomial pieces from knot to knot.

    Attributes:
        knots: strictly increasing times (k + 1,); at an inner knot the piece after it counts.
        coefficients: (k, terms, d); the value of piece i at time t is the sum over j of
            coefficients[i, j] (t - knots[i])**j.
    """

    knots: Float64Array
    coefficients: Float64Array

    def __init__(self, knots: ArrayLike, coefficients: ArrayLike) -> None:
        times = knot_times(knots, "knots")
        table = check.frozen(coefficients, "coefficients", shape=(len(times) - 1, "terms", "d"))
        if 0 in table.shape:
            raise InvalidInput(f"coefficients: expected no empty axis, got shape {table.shape}")
        vars(self).update(knots=times, coefficients=table)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return float(self.knots[0]), float(self.knots[-1])

    @property
    def degree(self) -> int:
        """The largest degree that the pieces can have."""
        return int(self.coefficients.shape[1]) - 1

    def smoothness(self, *, tolerance: float = 1e-9) -> Float64Array:
        """How many derivatives, the value counted as the first, agree at each inner knot, (k - 1,).

        Args:
            tolerance: largest difference that counts as none, relative to the largest derivative.
        """
        agree = np.zeros(len(self.knots) - 2)
        going = np.ones(len(self.knots) - 2, dtype=bool)
        for k in range(self.degree + 1):
            starts, ends = self.coefficients[1:, k], self._at_ends(k)
            scale = max(
                float(np.abs(self.coefficients[:, k]).max()), float(np.abs(ends).max(initial=0.0))
            )
            going = going & (np.abs(starts - ends).max(axis=1) <= tolerance * scale)
            agree += going
        return agree

    def _at_ends(self, k: int) -> Float64Array:
        """Derivative k over k! of each piece but the last at its end, (k - 1, d)."""
        widths = np.diff(self.knots)[:-1, None]
        ends = np.zeros_like(self.coefficients[1:, k])
        for j in range(k, self.degree + 1):
            ends += math.comb(j, k) * widths ** (j - k) * self.coefficients[:-1, j]
        return ends

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        rows = self.coefficients.reshape(-1, self.coefficients.shape[2])
        values = core.polynomial_values(
            self.knots, rows, np.atleast_1d(times), min(order, len(rows))
        )
        return values if times.ndim else values[0]

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> Self:
        table = self.coefficients @ matrix.T
        table[:, 0] += offset
        return replace(self, coefficients=table)

    def _stretched(self, factor: float) -> Self:
        powers = factor ** -np.arange(self.degree + 1.0)
        table = self.coefficients * powers[:, None]
        return replace(self, knots=self.knots * factor, coefficients=table)
