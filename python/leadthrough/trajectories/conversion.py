"""Exact conversions between splines, Bezier pieces and B-splines, and insertion of knots.

Source: Farin 2002, chapters 5 and 8; Ramshaw 1989, "Blossoms are polar forms"; Boehm 1980.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories.bezier import Bezier
from leadthrough.trajectories.bspline import BSpline
from leadthrough.trajectories.curve import Spline


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
