"""B-splines, and rational ones (NURBS).

Source: de Boor 2001; Piegl and Tiller 1997, section 4.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.interpolate

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.interpolation import of_bspline
from leadthrough.trajectories.spline import Spline, affine

_MOST_DEGREE = 20


@dataclass(frozen=True, eq=False)
class BSpline:
    """The curve of control points (n, d) and a knot vector (n + degree + 1,) that never falls.

    It lives where the basis adds up to one, from knot `degree` to knot n, both included; a knot
    that stands m times leaves degree - m derivatives there. Raises InvalidInput.
    """

    points: Float64Array
    knot_vector: Float64Array
    degree: int
    _curve: scipy.interpolate.BSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        degree = check.integer(self.degree, "degree", at_least=0, at_most=_MOST_DEGREE)
        points = curve.points(self.points, "points", least=degree + 1)
        knots = check.frozen(self.knot_vector, "knot_vector", shape=(len(points) + degree + 1,))
        if (np.diff(knots) < 0.0).any() or not knots[degree] < knots[len(points)]:
            raise InvalidInput("knot_vector: expected knots that never fall and span a domain")
        object.__setattr__(self, "degree", degree)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "knot_vector", knots)
        object.__setattr__(
            self, "_curve", scipy.interpolate.BSpline.construct_fast(knots, points, degree)
        )

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

    def evaluate(self, t: Any, derivative: int = 0) -> Float64Array:
        """Values or derivatives (n, d) at times (n,), (d,) at one time. Raises InvalidInput."""
        times = curve.times_inside(t, self.domain)
        return np.asarray(self._curve(times, curve.order(derivative)))

    def basis(self, t: Any) -> Float64Array:
        """(n, points) what each control point counts at times (n,); rows add up to one."""
        times = curve.times_inside(np.atleast_1d(t), self.domain)
        knots, degree = self.knot_vector, self.degree
        return np.asarray(scipy.interpolate.BSpline(knots, np.eye(len(self.points)), degree)(times))

    def transformed(self, matrix: Any, offset: Any = 0.0) -> BSpline:
        """The curve of matrix @ x + offset for every x of this one. Raises InvalidInput."""
        a, b = affine(matrix, offset, self.points.shape[1])
        return BSpline(self.points @ a.T + b, self.knot_vector, self.degree)

    def rescaled(self, factor: float) -> BSpline:
        """The same path, passed `factor` times as slowly. Raises InvalidInput."""
        stretch = check.number(factor, "factor", above=0.0)
        return BSpline(self.points, self.knot_vector * stretch, self.degree)

    def spline(self) -> Spline:
        """The same curve by its polynomial pieces."""
        return of_bspline(self._curve, self.knots)


@dataclass(frozen=True, eq=False)
class Nurbs:
    """A B-spline whose control points (n, d) count by weights (n,), > 0.

    Circles and other conics are exactly of this kind. Raises InvalidInput.
    """

    points: Float64Array
    weights: Float64Array
    knot_vector: Float64Array
    degree: int
    _lifted: BSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = curve.points(self.points, "points")
        weights = check.frozen(self.weights, "weights", shape=(len(points),))
        if (weights <= 0.0).any():
            raise InvalidInput(f"weights: expected numbers > 0, got {weights.min()}")
        lifted = np.column_stack([points * weights[:, None], weights])
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "weights", weights)
        object.__setattr__(self, "_lifted", BSpline(lifted, self.knot_vector, self.degree))
        object.__setattr__(self, "knot_vector", self._lifted.knot_vector)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return self._lifted.domain

    @property
    def knots(self) -> Float64Array:
        """The distinct knots of the domain."""
        return self._lifted.knots

    def evaluate(self, t: Any, derivative: int = 0) -> Float64Array:
        """Values or derivatives (n, d) at times (n,), (d,) at one time.

        Raises InvalidInput. Source: Piegl and Tiller 1997, eq. 4.8.
        """
        lifted = [self._lifted.evaluate(t, k) for k in range(curve.order(derivative) + 1)]
        found: list[Float64Array] = []
        for k, row in enumerate(lifted):
            value = row[..., :-1].copy()
            for i in range(1, k + 1):
                value -= math.comb(k, i) * lifted[i][..., -1:] * found[k - i]
            found.append(value / lifted[0][..., -1:])
        return found[-1]

    def transformed(self, matrix: Any, offset: Any = 0.0) -> Nurbs:
        """The curve of matrix @ x + offset for every x of this one. Raises InvalidInput."""
        a, b = affine(matrix, offset, self.points.shape[1])
        return Nurbs(self.points @ a.T + b, self.weights, self.knot_vector, self.degree)

    def rescaled(self, factor: float) -> Nurbs:
        """The same path, passed `factor` times as slowly. Raises InvalidInput."""
        stretch = check.number(factor, "factor", above=0.0)
        return Nurbs(self.points, self.weights, self.knot_vector * stretch, self.degree)
