"""Bezier curves (Grioli 2023, section 2.3; Farin 2002)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import BPoly

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.trajectories import curve
from leadthrough.trajectories.spline import Spline, affine

_MOST_POINTS = 100


@dataclass(frozen=True, eq=False)
class Bezier:
    """The curve of control points (n, d), of degree n - 1, over a domain of times.

    It begins at the first point towards the second, ends at the last from the last but one, and
    stays within the points' convex hull. Raises InvalidInput.
    """

    points: Float64Array
    domain: tuple[float, float] = (0.0, 1.0)
    _curve: BPoly = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = curve.points(self.points, "points")
        check.integer(len(points), "number of points", at_least=1, at_most=_MOST_POINTS)
        first, last = curve.knot_times(self.domain, "domain")[[0, -1]]
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "domain", (float(first), float(last)))
        object.__setattr__(
            self, "_curve", BPoly.construct_fast(points[:, None].copy(), self.knots, False)
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return Bezier, (self.points, self.domain)

    @property
    def knots(self) -> Float64Array:
        """The ends of the domain."""
        return np.array(self.domain)

    def evaluate(self, t: Any, derivative: int = 0) -> Float64Array:
        """Values or derivatives (n, d) at times (n,), (d,) at one time. Raises InvalidInput."""
        times = curve.times_inside(t, self.domain)
        return np.asarray(self._curve(times, curve.order(derivative)))

    def split(self, t: float) -> tuple[Bezier, Bezier]:
        """The curves before and after a time inside the domain, by de Casteljau's construction.

        Raises InvalidInput.
        """
        first, last = self.domain
        time = check.number(t, "t", above=first, below=last)
        levels = de_casteljau(self.points, (time - first) / (last - first))
        before = np.array([level[0] for level in levels])
        after = np.array([level[-1] for level in reversed(levels)])
        return Bezier(before, (first, time)), Bezier(after, (time, last))

    def elevated(self) -> Bezier:
        """The same curve with one control point more."""
        shares = np.arange(1, len(self.points))[:, None] / len(self.points)
        inner = shares * self.points[:-1] + (1.0 - shares) * self.points[1:]
        return Bezier(np.vstack([self.points[:1], inner, self.points[-1:]]), self.domain)

    def derived(self) -> Bezier:
        """The curve of its velocities: the hodograph, one degree lower."""
        degree = len(self.points) - 1
        if degree == 0:
            return Bezier(np.zeros_like(self.points), self.domain)
        return Bezier(
            degree / (self.domain[1] - self.domain[0]) * np.diff(self.points, axis=0), self.domain
        )

    def transformed(self, matrix: Any, offset: Any = 0.0) -> Bezier:
        """The curve of matrix @ x + offset for every x of this one. Raises InvalidInput."""
        a, b = affine(matrix, offset, self.points.shape[1])
        return Bezier(self.points @ a.T + b, self.domain)

    def rescaled(self, factor: float) -> Bezier:
        """The same path, passed `factor` times as slowly. Raises InvalidInput."""
        stretch = check.number(factor, "factor", above=0.0)
        return Bezier(self.points, (self.domain[0] * stretch, self.domain[1] * stretch))

    def spline(self) -> Spline:
        """The same curve as one polynomial piece."""
        orders = range(len(self.points))
        rows = [self.evaluate(self.domain[0], k) / math.factorial(k) for k in orders]
        return Spline(self.knots, np.array(rows)[None])


def de_casteljau(points: Any, share: float) -> list[Float64Array]:
    """All levels of the construction at a share of the domain: (n, d), (n - 1, d), ..., (1, d).

    Each joins its neighbours' lines at the share; the last is the curve's point.
    Raises InvalidInput.
    """
    s = check.number(share, "share", at_least=0.0, at_most=1.0)
    levels = [curve.points(points, "points")]
    while len(levels[-1]) > 1:
        levels.append((1.0 - s) * levels[-1][:-1] + s * levels[-1][1:])
    return levels
