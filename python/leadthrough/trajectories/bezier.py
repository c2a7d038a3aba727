"""Bezier curves.

Source: Grioli 2023, section 2.3; Farin 2002.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import PointCurve
from leadthrough.trajectories.spline import Spline

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

_MOST_POINTS = 100


@dataclass(frozen=True, eq=False, init=False)
class Bezier(PointCurve):
    """The curve of control points, of degree n - 1.

    It begins at the first point towards the second, ends at the last coming from the last but one,
    and stays within the points' convex hull.

    Attributes:
        points: control points (n, d); (n,) are taken as one-dimensional.
        domain: first and last time.

    Raises:
        InvalidInput: if the points are malformed or more than 100, or the domain does not rise.
    """

    points: Float64Array
    domain: tuple[float, float]
    _curve: BPoly = field(init=False, repr=False)

    def __init__(self, points: ArrayLike, domain: ArrayLike = (0.0, 1.0)) -> None:
        from scipy.interpolate import BPoly

        table = curve.points(points, "points")
        check.integer(len(table), "number of points", at_least=1, at_most=_MOST_POINTS)
        ends = curve.knot_times(domain, "domain")[[0, -1]]
        vars(self).update(
            points=table,
            domain=(float(ends[0]), float(ends[1])),
            _curve=BPoly.construct_fast(table[:, None].copy(), ends, False),
        )

    # Any: the protocol of pickle.
    def __reduce__(self) -> tuple[Any, ...]:
        return Bezier, (self.points, self.domain)

    @property
    def knots(self) -> Float64Array:
        """The ends of the domain."""
        return np.array(self.domain)

    def split(self, t: float) -> tuple[Bezier, Bezier]:
        """The curves before and after a time, by de Casteljau's construction.

        Args:
            t: inside the domain.

        Raises:
            InvalidInput: if it is not.
        """
        first, last = self.domain
        time = check.number(t, "t", above=first, below=last)
        levels = de_casteljau(self.points, (time - first) / (last - first))
        before = np.array([level[0] for level in levels])
        after = np.array([level[-1] for level in reversed(levels)])
        return Bezier(before, (first, time)), Bezier(after, (time, last))

    def elevated(self) -> Bezier:
        """The same curve with one more control point."""
        fractions = np.arange(1, len(self.points))[:, None] / len(self.points)
        inner = fractions * self.points[:-1] + (1.0 - fractions) * self.points[1:]
        return Bezier(np.vstack([self.points[:1], inner, self.points[-1:]]), self.domain)

    def derived(self) -> Bezier:
        """The curve of its velocities: the hodograph, one degree lower."""
        degree = len(self.points) - 1
        if degree == 0:
            return Bezier(np.zeros_like(self.points), self.domain)
        return Bezier(
            degree / (self.domain[1] - self.domain[0]) * np.diff(self.points, axis=0), self.domain
        )

    def spline(self) -> Spline:
        """The same curve as one polynomial piece."""
        orders = range(len(self.points))
        rows = [self.evaluate(self.domain[0], k) / math.factorial(k) for k in orders]
        return Spline(self.knots, np.array(rows)[None])

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        return np.asarray(self._curve(times, order))

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> Self:
        return replace(self, points=self.points @ matrix.T + offset)

    def _stretched(self, factor: float) -> Self:
        return replace(self, domain=(self.domain[0] * factor, self.domain[1] * factor))


def de_casteljau(points: ArrayLike, fraction: float) -> list[Float64Array]:
    """All levels of de Casteljau's construction: (n, d), (n - 1, d), ..., (1, d).

    Each level divides the lines between neighbours of the one before at the fraction; the last is
    the curve's point.

    Args:
        points: control points (n, d).
        fraction: of the domain, from 0 to 1.

    Raises:
        InvalidInput: if the points are malformed or the fraction lies outside [0, 1].
    """
    s = check.number(fraction, "fraction", at_least=0.0, at_most=1.0)
    levels = [curve.points(points, "points")]
    while len(levels[-1]) > 1:
        levels.append((1.0 - s) * levels[-1][:-1] + s * levels[-1][1:])
    return levels
