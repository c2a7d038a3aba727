"""B-splines and rational ones (NURBS), also fitted near points or through them, and conversions.

Source: de Boor 2001; Piegl and Tiller 1997, sections 4.3, 9.2.1 and 9.4.1; Grioli 2023, section
2.5; for conversions Farin 2002, chapters 5 and 8; Ramshaw 1989, "Blossoms are polar forms"; Boehm
1980.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.bezier import Bezier
from leadthrough.trajectories.curve import PointCurve, Spline
from leadthrough.trajectories.interpolation import of_bspline

if TYPE_CHECKING:
    import scipy.interpolate


_MAX_DEGREE = 20


@dataclass(frozen=True, eq=False, init=False)
class BSpline(PointCurve):
    """The curve of control points and a knot vector that never falls.

    It lives where the basis functions add up to one, from knot `degree` to knot n, both included;
    a knot of multiplicity m leaves degree - m continuous derivatives there.

    Attributes:
        points: control points (n, d); (n,) are taken as one-dimensional.
        knot_vector: (n + degree + 1,).
        degree: of the pieces, 0 to 20.
    """

    points: Float64Array
    knot_vector: Float64Array
    degree: int
    _curve: scipy.interpolate.BSpline = field(init=False, repr=False)

    def __init__(self, points: ArrayLike, knot_vector: ArrayLike, degree: int) -> None:
        import scipy.interpolate

        degree = check.integer(degree, "degree", at_least=0, at_most=_MAX_DEGREE)
        table = curve.points(points, "points", least=degree + 1)
        knots = check.frozen(knot_vector, "knot_vector", shape=(len(table) + degree + 1,))
        if (np.diff(knots) < 0.0).any() or not knots[degree] < knots[len(table)]:
            raise InvalidInput("knot_vector: expected knots that never fall and span a domain")
        vars(self).update(
            points=table,
            knot_vector=knots,
            degree=degree,
            _curve=scipy.interpolate.BSpline.construct_fast(knots, table, degree),
        )

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return float(self.knot_vector[self.degree]), float(self.knot_vector[len(self.points)])

    @property
    def knots(self) -> Float64Array:
        """The distinct knots of the domain."""
        return np.unique(self.knot_vector[self.degree : len(self.points) + 1])

    def basis(self, t: ArrayLike) -> Float64Array:
        """Weights (n, points) of the control points; rows add up to one.

        Args:
            t: times of the domain (n,).
        """
        import scipy.interpolate

        times = curve.times_inside(np.atleast_1d(t), self.domain)
        knots, degree = self.knot_vector, self.degree
        return np.asarray(scipy.interpolate.BSpline(knots, np.eye(len(self.points)), degree)(times))

    def spline(self) -> Spline:
        """The same curve by its polynomial pieces."""
        return of_bspline(self._curve, self.knots)

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        return np.asarray(self._curve(times, order))

    def _stretched(self, factor: float) -> Self:
        return replace(self, knot_vector=self.knot_vector * factor)


@dataclass(frozen=True, eq=False, init=False)
class Nurbs(PointCurve):
    """A B-spline whose control points are weighted; circles and other conics are exactly such.

    Attributes:
        points: control points (n, d); (n,) are taken as one-dimensional.
        weights: (n,), > 0.
        knot_vector: (n + degree + 1,).
        degree: of the pieces, 0 to 20.
    """

    points: Float64Array
    weights: Float64Array
    knot_vector: Float64Array
    degree: int
    _lifted: BSpline = field(init=False, repr=False)

    def __init__(
        self, points: ArrayLike, weights: ArrayLike, knot_vector: ArrayLike, degree: int
    ) -> None:
        table = curve.points(points, "points")
        factors = check.frozen(weights, "weights", shape=(len(table),))
        if (factors <= 0.0).any():
            raise InvalidInput(f"weights: expected numbers > 0, got {factors.min()}")
        lifted = BSpline(np.column_stack([table * factors[:, None], factors]), knot_vector, degree)
        vars(self).update(
            points=table,
            weights=factors,
            knot_vector=lifted.knot_vector,
            degree=lifted.degree,
            _lifted=lifted,
        )

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return self._lifted.domain

    @property
    def knots(self) -> Float64Array:
        """The distinct knots of the domain."""
        return self._lifted.knots

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        """By the derivatives of the weighted curve: Piegl and Tiller 1997, eq. 4.8."""
        lifted = [self._lifted.evaluate(times, k) for k in range(order + 1)]
        found: list[Float64Array] = []
        for k, row in enumerate(lifted):
            value = row[..., :-1].copy()
            for i in range(1, k + 1):
                value -= math.comb(k, i) * lifted[i][..., -1:] * found[k - i]
            found.append(value / lifted[0][..., -1:])
        return found[-1]

    def _stretched(self, factor: float) -> Self:
        return replace(self, knot_vector=self.knot_vector * factor)


def bspline_near(
    times: ArrayLike, points: ArrayLike, *, control_points: int, degree: int = 3
) -> BSpline:
    """The B-spline of a few control points with the least squared distance from points.

    It passes through the first and the last point; the knots are spread so that every piece has
    about as many points.

    Args:
        times: strictly increasing times (n,) of the points.
        points: (n, d).
        control_points: number of control points, degree + 1 to n.
        degree: of the pieces, 1 to 20.
    """
    t, table, k = _checked(times, points, degree)
    count = check.integer(control_points, "control_points", at_least=k + 1, at_most=len(table))
    knots = _spread_knots(t, count, k)
    basis = BSpline(np.eye(count), knots, k).evaluate(t)
    ends = table[[0, -1]]
    controls = np.empty((count, table.shape[1]))
    controls[[0, -1]] = ends
    if count > 2:
        rest = table - basis[:, [0, -1]] @ ends
        inner, *_ = np.linalg.lstsq(basis[1:-1, 1:-1], rest[1:-1], rcond=None)
        controls[1:-1] = inner
    return BSpline(controls, knots, k)


def nurbs_through(
    times: ArrayLike, points: ArrayLike, *, weights: ArrayLike, degree: int = 3
) -> Nurbs:
    """The rational B-spline through points at times, with a given weight of each control point.

    Args:
        times: strictly increasing times (n,) of the points.
        points: (n, d), n > degree.
        weights: of the n control points, > 0; equal ones give a B-spline.
        degree: of the pieces, 1 to 20.
    """
    t, table, k = _checked(times, points, degree)
    factors = check.array(weights, "weights", shape=(len(table),))
    if (factors <= 0.0).any():
        raise InvalidInput(f"weights: expected numbers > 0, got {factors.min()}")
    knots = _averaged_knots(t, k)
    weighted = BSpline(np.eye(len(table)), knots, k).evaluate(t) * factors
    rational = weighted / weighted.sum(axis=1, keepdims=True)
    return Nurbs(np.linalg.solve(rational, table), factors, knots, k)


def _checked(
    times: ArrayLike, points: ArrayLike, degree: int
) -> tuple[Float64Array, Float64Array, int]:
    k = check.integer(degree, "degree", at_least=1, at_most=20)
    t = curve.knot_times(times, "times")
    return t, curve.points(points, "points", count=len(t), least=k + 1), k


def _averaged_knots(t: Float64Array, k: int) -> Float64Array:
    """Knots (n + k + 1,) each the mean of k neighbouring times (Piegl and Tiller 1997, eq. 9.8)."""
    inner = [t[j : j + k].mean() for j in range(1, len(t) - k)]
    return np.concatenate([np.repeat(t[0], k + 1), inner, np.repeat(t[-1], k + 1)])


def _spread_knots(t: Float64Array, count: int, k: int) -> Float64Array:
    """Knots (count + k + 1,) with about as many times between each (ibid., eqs. 9.68 and 9.69)."""
    if count == len(t):
        return _averaged_knots(t, k)
    pieces = count - k
    places = np.arange(1, pieces) * len(t) / pieces
    rows = places.astype(int)
    inner = t[rows - 1] + (places - rows) * (t[rows] - t[rows - 1])
    return np.concatenate([np.repeat(t[0], k + 1), inner, np.repeat(t[-1], k + 1)])


def bezier_pieces(made: Spline | BSpline) -> list[Bezier]:
    """The Bezier curves, from knot to knot, that a spline consists of.

    Those of `smooth(times, points, continuity=m)` go through points with m continuous derivatives.
    Curves that are continued one after another from their start may do so too, but amplify their
    errors from piece to piece; here all pieces are solved for together.

    Args:
        made: a spline or a B-spline.
    """
    spline = made.spline() if isinstance(made, BSpline) else _spline(made)
    orders = np.arange(spline.degree + 1)
    powers = np.diff(spline.knots)[:, None] ** orders
    # A control point is the sum over j of C(i, j) / C(degree, j) c_j width^j.
    matrix = np.array(
        [[math.comb(i, j) / math.comb(spline.degree, j) for j in orders] for i in orders]
    )
    points = matrix @ (spline.coefficients * powers[:, :, None])
    ends = zip(spline.knots[:-1], spline.knots[1:], strict=True)
    return [Bezier(own, domain) for own, domain in zip(points, ends, strict=True)]


def as_bspline(spline: Spline, *, tolerance: float = 1e-9) -> BSpline:
    """The same curve as a B-spline, with each knot as often as its smoothness needs.

    Args:
        spline: a spline; Bezier curves are one by `joined`.
        tolerance: of derivatives that agree at a knot, as for `Spline.smoothness`.

    Raises:
        InvalidInput: for a degree above 20.
    """
    degree, times = _spline(spline).degree, spline.knots
    counts = degree + 1 - spline.smoothness(tolerance=tolerance).astype(int)
    knots = np.repeat(times, [degree + 1, *np.clip(counts, 0, degree + 1), degree + 1])
    points = []
    for i in range(len(knots) - degree - 1):
        own = knots[i : i + degree + 2]
        # Any piece inside the function's support will do; the one in its middle has small numbers.
        middle = 0.5 * (own[:-1] + own[1:])[own[:-1] < own[1:]]
        inside = middle[len(middle) // 2]
        piece = int(np.searchsorted(times, inside, side="right")) - 1
        points.append(_blossom(spline.coefficients[piece], own[1:-1] - times[piece]))
    return BSpline(np.array(points), knots, degree)


def with_knot(bspline: BSpline, time: float) -> BSpline:
    """The same curve with one more knot and control point.

    Args:
        bspline: the curve.
        time: of the knot, inside the domain; there at most `degree` times.
    """
    first, last = bspline.domain
    t = check.number(time, "time", above=first, below=last)
    knots, degree = bspline.knot_vector, bspline.degree
    if (knots == t).sum() >= max(degree, 1):
        raise InvalidInput(f"time: expected one that is a knot less than {degree} times, got {t}")
    after = int(np.searchsorted(knots, t, side="right"))
    changed = np.arange(after - degree, after)
    share = ((t - knots[changed]) / (knots[changed + degree] - knots[changed]))[:, None]
    moved = share * bspline.points[changed] + (1.0 - share) * bspline.points[changed - 1]
    points = np.vstack([bspline.points[: after - degree], moved, bspline.points[after - 1 :]])
    return BSpline(points, np.insert(knots, after, t), degree)


def _blossom(coefficients: Float64Array, at: ArrayLike) -> Float64Array:
    """The polar form of a polynomial (terms, d) at as many times as its degree."""
    symmetric = np.zeros(len(coefficients))  # elementary symmetric polynomials of the times
    symmetric[0] = 1.0
    for each in np.asarray(at):
        symmetric[1:] += each * symmetric[:-1].copy()
    degree = len(coefficients) - 1
    weights = symmetric / [math.comb(degree, j) for j in range(degree + 1)]
    return np.asarray(weights @ coefficients)


def _spline(value: object) -> Spline:
    if not isinstance(value, Spline):
        raise InvalidInput(f"spline: expected a Spline or a BSpline, got {type(value).__name__}")
    return value
