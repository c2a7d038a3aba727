"""Bezier curves.

Source: Grioli 2023, section 2.3; Farin 2002.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import PointCurve, Spline

_MAX_POINTS = 100
# Ends that are nearer than this, relative to the numbers' size, meet.
_JOINED = 1e-9
# Factorials of higher orders lose the digits of a derivative.
_MAX_CONTINUITY = 20


@dataclass(frozen=True, eq=False, init=False)
class Bezier(PointCurve):
    """The curve of control points, of degree n - 1.

    It begins at the first point towards the second, ends at the last coming from the last but one,
    and stays within the points' convex hull.

    Attributes:
        points: control points (n, d); (n,) are taken as one-dimensional.
        domain: first and last time.
    """

    points: Float64Array
    domain: tuple[float, float]

    def __init__(self, points: ArrayLike, domain: ArrayLike = (0.0, 1.0)) -> None:
        table = curve.points(points, "points")
        check.integer(len(table), "number of points", at_least=1, at_most=_MAX_POINTS)
        ends = curve.knot_times(domain, "domain")[[0, -1]]
        vars(self).update(points=table, domain=(float(ends[0]), float(ends[1])))

    @property
    def knots(self) -> Float64Array:
        """The ends of the domain."""
        return np.array(self.domain)

    def split(self, t: float) -> tuple[Bezier, Bezier]:
        """The curves before and after a time, by de Casteljau's construction.

        Args:
            t: inside the domain.
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

    def continued(self, points: ArrayLike, *, duration: float, continuity: int = 2) -> Bezier:
        """A curve that follows this one, with the same derivatives where they meet.

        Its first control points are placed so that positions and all derivatives up to an order
        agree; the others are free.

        Args:
            points: its further control points (n, d), n >= 1.
            duration: of the new curve, in the unit of the domain, > 0.
            continuity: m of C^m, 0 to 20: the highest derivative that agrees.

        Raises:
            InvalidInput: if the curve would have more than 100 points.
        """
        free = curve.points(points, "points")
        if free.shape[1] != self.points.shape[1]:
            raise check.refused(
                "points", f"{self.points.shape[1]} columns as this curve has", free.shape[1]
            )
        length = check.number(duration, "duration", above=0.0)
        most = check.integer(continuity, "continuity", at_least=0, at_most=_MAX_CONTINUITY)
        degree, end = most + len(free), self.domain[1]
        # The k-th difference of the first control points gives the k-th derivative at the start.
        differences = [
            self.evaluate(end, k) * length**k / math.perm(degree, k) for k in range(most + 1)
        ]
        placed = [
            sum(math.comb(i, k) * differences[k] for k in range(i + 1)) for i in range(most + 1)
        ]
        return Bezier(np.vstack([*placed, free]), (end, end + length))

    def spline(self) -> Spline:
        """The same curve as one polynomial piece."""
        orders = range(len(self.points))
        rows = [self.evaluate(self.domain[0], k) / math.factorial(k) for k in orders]
        return Spline(self.knots, np.array(rows)[None])

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        hodograph = self
        for _ in range(min(order, len(self.points))):
            hodograph = hodograph.derived()
        first, last = self.domain
        fractions = (np.atleast_1d(times) - first) / (last - first)
        values = core.bezier_values(hodograph.points, fractions)
        return values if times.ndim else values[0]

    def _stretched(self, factor: float) -> Self:
        return replace(self, domain=(self.domain[0] * factor, self.domain[1] * factor))


def joined(pieces: Sequence[Bezier]) -> Spline:
    """One curve of Bezier curves that follow one another, each beginning when the last one ends.

    `Spline.smoothness` tells how many derivatives agree where they meet.

    Args:
        pieces: at least one; they may differ in degree.

    Raises:
        InvalidInput: if one does not begin where and when the one before ends.
    """
    if not pieces:
        raise InvalidInput("pieces: expected at least one Bezier curve, got none")
    for i, (before, after) in enumerate(pairwise(pieces)):
        if before.points.shape[1] != after.points.shape[1]:
            raise check.refused(
                f"pieces[{i + 1}]", f"{before.points.shape[1]} columns", after.points.shape[1]
            )
        size = 1.0 + float(np.abs(before.points).max())
        apart = float(np.abs(after.points[0] - before.points[-1]).max())
        if apart > _JOINED * size or after.domain[0] != before.domain[1]:
            raise InvalidInput(
                f"pieces[{i + 1}]: expected a curve from where and when the one before ends, "
                f"{before.points[-1]} at {before.domain[1]}, got one from {after.points[0]} at "
                f"{after.domain[0]}; make it with `continued`"
            )
    rows = [piece.spline().coefficients[0] for piece in pieces]
    table = np.zeros((len(rows), max(map(len, rows)), pieces[0].points.shape[1]))
    for piece, row in zip(table, rows, strict=True):
        piece[: len(row)] = row
    return Spline([pieces[0].domain[0], *(piece.domain[1] for piece in pieces)], table)


def de_casteljau(points: ArrayLike, fraction: float) -> list[Float64Array]:
    """All levels of de Casteljau's construction: (n, d), (n - 1, d), ..., (1, d).

    Each level divides the lines between neighbours of the one before at the fraction; the last is
    the curve's point.

    Args:
        points: control points (n, d).
        fraction: of the domain, from 0 to 1.
    """
    s = check.number(fraction, "fraction", at_least=0.0, at_most=1.0)
    levels = [curve.points(points, "points")]
    while len(levels[-1]) > 1:
        levels.append((1.0 - s) * levels[-1][:-1] + s * levels[-1][1:])
    return levels
