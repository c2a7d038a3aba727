"""B-splines, and rational ones (NURBS).

Source: de Boor 2001; Piegl and Tiller 1997, section 4.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import PointCurve
from leadthrough.trajectories.interpolation import of_bspline
from leadthrough.trajectories.spline import Spline

if TYPE_CHECKING:
    import scipy.interpolate

_MOST_DEGREE = 20


@dataclass(frozen=True, eq=False, init=False)
class BSpline(PointCurve):
    """The curve of control points and a knot vector that never falls.

    It lives where the basis functions add up to one, from knot `degree` to knot n, both included;
    a knot of multiplicity m leaves degree - m continuous derivatives there.

    Attributes:
        points: control points (n, d); (n,) are taken as one-dimensional.
        knot_vector: (n + degree + 1,).
        degree: of the pieces, 0 to 20.

    Raises:
        InvalidInput: if one of them is malformed, or the knots fall or span no domain.
    """

    points: Float64Array
    knot_vector: Float64Array
    degree: int
    _curve: scipy.interpolate.BSpline = field(init=False, repr=False)

    def __init__(self, points: ArrayLike, knot_vector: ArrayLike, degree: int) -> None:
        import scipy.interpolate

        degree = check.integer(degree, "degree", at_least=0, at_most=_MOST_DEGREE)
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

    # Any: the protocol of pickle.
    def __reduce__(self) -> tuple[Any, ...]:
        return BSpline, (self.points, self.knot_vector, self.degree)

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

        Raises:
            InvalidInput: if a time lies outside the domain.
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

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> Self:
        return replace(self, points=self.points @ matrix.T + offset)

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

    Raises:
        InvalidInput: as for `BSpline`, and if a weight is not > 0.
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

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> Self:
        return replace(self, points=self.points @ matrix.T + offset)

    def _stretched(self, factor: float) -> Self:
        return replace(self, knot_vector=self.knot_vector * factor)
