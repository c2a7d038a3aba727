"""B-splines with fewer control points than there are points, and rational ones through points.

Source: Piegl and Tiller 1997, sections 9.2.1 and 9.4.1; Grioli 2023, section 2.5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.bspline import BSpline, Nurbs


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

    Raises:
        InvalidInput: if the times do not rise, the shapes do not fit, or a number is out of range.
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

    Raises:
        InvalidInput: if the times do not rise, the shapes do not fit, or a number is out of range.
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
    """Knots (n + k + 1,) each the mean of k neighbouring times: interpolation then has a solution.

    Source: Piegl and Tiller 1997, eq. 9.8.
    """
    inner = [t[j : j + k].mean() for j in range(1, len(t) - k)]
    return np.concatenate([np.repeat(t[0], k + 1), inner, np.repeat(t[-1], k + 1)])


def _spread_knots(t: Float64Array, count: int, k: int) -> Float64Array:
    """Knots (count + k + 1,) between which about as many times lie each, never none.

    Source: Piegl and Tiller 1997, eqs. 9.68 and 9.69.
    """
    if count == len(t):
        return _averaged_knots(t, k)
    pieces = count - k
    places = np.arange(1, pieces) * len(t) / pieces
    rows = places.astype(int)
    inner = t[rows - 1] + (places - rows) * (t[rows] - t[rows - 1])
    return np.concatenate([np.repeat(t[0], k + 1), inner, np.repeat(t[-1], k + 1)])
