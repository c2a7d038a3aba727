"""Splines through points (n, d) at given times (n,), which increase strictly.

A condition at an end is (d,), or one number for all dimensions.

Source: Grioli 2023, section 2.2; de Boor 2001, "A practical guide to splines".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import Spline

if TYPE_CHECKING:
    from scipy.interpolate import BSpline, PPoly
    from scipy.sparse import lil_matrix

_MAX_CONTINUITY = 10
_MIN_SMOOTHED = 5
_ROUNDING = 1e-6  # by which a spline may miss its points, as a fraction of the largest number
ENDS = ("rest", "natural")


def linear(times: ArrayLike, points: ArrayLike) -> Spline:
    """Straight lines between points."""
    t, x = _through(times, points)
    slopes = np.diff(x, axis=0) / np.diff(t)[:, None]
    return Spline(t, np.stack([x[:-1], slopes], axis=1))


def hermite(times: ArrayLike, points: ArrayLike, velocities: ArrayLike) -> Spline:
    """Cubic pieces through points with given velocities (n, d)."""
    from scipy.interpolate import CubicHermiteSpline

    t, x = _through(times, points)
    v = check.array(
        curve.points(velocities, "velocities", count=len(x)), "velocities", shape=x.shape
    )
    return _of_scipy(CubicHermiteSpline(t, x, v))


def clamped_cubic(
    times: ArrayLike,
    points: ArrayLike,
    *,
    start_velocity: ArrayLike = 0.0,
    end_velocity: ArrayLike = 0.0,
) -> Spline:
    """The C2 cubic spline through points with given velocities at both ends."""
    from scipy.interpolate import CubicSpline

    t, x = _through(times, points)
    first = check.row(start_velocity, "start_velocity", width=x.shape[1])
    last = check.row(end_velocity, "end_velocity", width=x.shape[1])
    return _of_scipy(CubicSpline(t, x, bc_type=((1, first), (1, last))))


def natural_cubic(
    times: ArrayLike,
    points: ArrayLike,
    *,
    start_acceleration: ArrayLike = 0.0,
    end_acceleration: ArrayLike = 0.0,
) -> Spline:
    """The C2 cubic spline through points with given accelerations at both ends.

    With none, it is the natural spline: of all C2 curves through the points the one with the least
    integral of the squared acceleration.
    """
    from scipy.interpolate import CubicSpline

    t, x = _through(times, points)
    first = check.row(start_acceleration, "start_acceleration", width=x.shape[1])
    last = check.row(end_acceleration, "end_acceleration", width=x.shape[1])
    return _of_scipy(CubicSpline(t, x, bc_type=((2, first), (2, last))))


def periodic_cubic(times: ArrayLike, points: ArrayLike) -> Spline:
    """The C2 cubic spline through points that continues at its end as it began.

    Args:
        times: strictly increasing, (n,), n >= 3.
        points: (n, d), the last the same as the first.
    """
    from scipy.interpolate import CubicSpline

    t, x = _through(times, points)
    if len(t) < 3 or not np.allclose(x[0], x[-1], rtol=0.0, atol=1e-12 * np.abs(x).max()):
        raise check.refused("points", f"three or more, the last like the first {x[0]}", x[-1])
    return _of_scipy(CubicSpline(t, np.vstack([x[:-1], x[:1]]), bc_type="periodic"))


def smooth(
    times: ArrayLike,
    points: ArrayLike,
    *,
    continuity: int,
    ends: Literal["rest", "natural"] = "rest",
) -> Spline:
    """The spline of degree continuity + 1 through points, with that many continuous derivatives.

    Its knots are the times; that leaves `continuity` conditions at the ends (Grioli 2023,
    eq. 2.12), split between them, the start first.

    Args:
        continuity: number of continuous derivatives, 0 to 10.
        ends: the derivatives that are zero there: "rest" those from the first up, "natural" those
            from the highest down.

    Raises:
        InvalidInput: if the times are too uneven.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import vstack
    from scipy.sparse.linalg import spsolve

    t, x = _through(times, points)
    k = check.integer(continuity, "continuity", at_least=0, at_most=_MAX_CONTINUITY)
    if k == 0:
        return linear(t, x)
    rest = check.choice(ends, "ends", ENDS) == "rest"
    conditions = [
        range(1, count + 1) if rest else range(k, k - count, -1) for count in ((k + 1) // 2, k // 2)
    ]
    knots = np.concatenate([t[[0] * (k + 2)], t[1:-1], t[[-1] * (k + 2)]])
    rows = [_derivative_rows(knots, k + 1, *end) for end in zip((0, -1), conditions, strict=True)]
    matrix = vstack([rows[0], BSpline.design_matrix(t, knots, k + 1), rows[1]], format="csc")
    zeros = [np.zeros((len(end), x.shape[1])) for end in conditions]
    values = spsolve(matrix, np.vstack([zeros[0], x, zeros[1]])).reshape(-1, x.shape[1])
    return passing(BSpline(knots, values, k + 1), t, x)


def _derivative_rows(
    knots: Float64Array, degree: int, end: int, orders: Sequence[int]
) -> lil_matrix:
    """Derivatives of some orders at an end, of all basis functions: (orders, n), sparse."""
    from scipy.interpolate import BSpline
    from scipy.sparse import lil_matrix

    count = len(knots) - degree - 1
    nearest = slice(degree + 1) if end == 0 else slice(count - degree - 1, count)
    basis = BSpline(knots, np.eye(count, degree + 1, k=-nearest.indices(count)[0]), degree)
    rows = lil_matrix((len(orders), count))
    for i, order in enumerate(orders):
        rows[i, nearest] = basis(knots[end], order)
    return rows


def smoothing(times: ArrayLike, points: ArrayLike, *, weight: float) -> Spline:
    """The natural cubic spline that trades closeness to points for smoothness.

    Args:
        times: strictly increasing, (n,), n >= 5.
        points: (n, d).
        weight: >= 0, of the integral of the squared acceleration beside the sum of squared errors;
            with 0 the spline goes through the points.

    Source: Reinsch 1967.
    """
    from scipy.interpolate import make_smoothing_spline

    t, x = _through(times, points, least=_MIN_SMOOTHED)
    penalty = check.number(weight, "weight", at_least=0.0)
    columns = [make_smoothing_spline(t, column, lam=penalty) for column in x.T]
    return Spline(t, np.concatenate([_table(column, t)[:, :, None] for column in columns], axis=2))


def passing(spline: BSpline, times: Float64Array, points: Float64Array) -> Spline:
    """The pieces of a B-spline that was solved for, if they pass its points."""
    if np.isfinite(spline.c).all():
        made = of_bspline(spline, times)
        if np.abs(made.evaluate(times) - points).max() <= _ROUNDING * np.abs(points).max():
            return made
    raise InvalidInput("times: expected steps of similar length; no spline passes these points")


def of_bspline(spline: BSpline, breaks: Float64Array) -> Spline:
    """The pieces of a SciPy B-spline between its distinct knots."""
    return Spline(breaks, _table(spline, breaks))


def _table(spline: BSpline, breaks: Float64Array) -> Float64Array:
    orders = range(spline.k + 1)
    return np.stack([spline(breaks[:-1], nu=k) / math.factorial(k) for k in orders], axis=1)


def _of_scipy(pieces: PPoly) -> Spline:
    return Spline(pieces.x, pieces.c[::-1].transpose(1, 0, 2))


def _through(
    times: ArrayLike, points: ArrayLike, *, least: int = 2
) -> tuple[Float64Array, Float64Array]:
    """Rising times (n,) and as many points (n, d)."""
    t = curve.knot_times(times, "times")
    return t, curve.points(points, "points", count=len(t), least=least)
