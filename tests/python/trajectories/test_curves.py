"""Properties of every curve; a new kind joins with one line."""

import pickle

import numpy as np
import pytest
from refusals import refused

from leadthrough import trajectories as tr
from leadthrough.errors import InvalidInput

TIMES = np.array([0.0, 0.5, 1.2, 1.5, 2.6, 3.0])
POINTS = np.random.default_rng(1).normal(size=(6, 3))
KNOTS = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0]
CURVES = {
    "Lagrange": lambda x: tr.Lagrange(TIMES, x),
    "osculating": lambda x: tr.osculating(TIMES, x, x[::-1] - x),
    "linear": lambda x: tr.linear(TIMES, x),
    "hermite": lambda x: tr.hermite(TIMES, x, x[::-1] - x),
    "clamped_cubic": lambda x: tr.clamped_cubic(TIMES, x),
    "natural_cubic": lambda x: tr.natural_cubic(TIMES, x),
    "periodic_cubic": lambda x: tr.periodic_cubic(TIMES, np.vstack([x[:-1], x[:1]])),
    "smooth": lambda x: tr.smooth(TIMES, x, continuity=4),
    "smoothing": lambda x: tr.smoothing(TIMES, x, weight=0.01),
    "Bezier": lambda x: tr.Bezier(x, (0.0, 3.0)),
    "BSpline": lambda x: tr.BSpline(x, KNOTS, 3),
    "Nurbs": lambda x: tr.Nurbs(x, [1.0, 2.0, 0.5, 1.0, 3.0, 1.0], KNOTS, 3),
    "minimum_jerk": lambda x: tr.minimum_jerk(x[0], x[-1], duration=3.0),
    "minimum_jerk_through": lambda x: tr.minimum_jerk_through(TIMES, x),
}


@pytest.fixture(params=CURVES)
def make(request):
    return CURVES[request.param]


def inner_times(curve, count=40):
    """Times away from knots, where every derivative exists."""
    t = np.linspace(*curve.domain, count + 2)[1:-1]
    return t[np.abs(t[:, None] - curve.knots).min(axis=1) > 1e-3]


def test_a_curve_is_a_curve(make):
    curve = make(POINTS)
    assert isinstance(curve, tr.Curve)
    assert curve.domain == (0.0, 3.0)
    assert curve.knots[0] == 0.0
    assert curve.knots[-1] == 3.0
    assert (np.diff(curve.knots) > 0.0).all()


def test_one_time_is_a_row_of_many(make):
    curve = make(POINTS)
    for order in (0, 1, 2):
        many = curve.evaluate([0.3, 1.7], order)
        assert many.shape == (2, 3)
        np.testing.assert_allclose(curve.evaluate(1.7, order), many[1], rtol=1e-10)


def test_derivatives_are_those_of_the_values(make):
    curve = make(POINTS)
    t, h = inner_times(curve), 1e-5
    for order in (1, 2, 3):
        slopes = (curve.evaluate(t + h, order - 1) - curve.evaluate(t - h, order - 1)) / (2.0 * h)
        scale = 1.0 + np.abs(slopes).max()
        np.testing.assert_allclose(curve.evaluate(t, order), slopes, atol=1e-6 * scale)


def test_affine_maps_of_the_points_map_the_curve(make):
    rng = np.random.default_rng(2)
    matrix, offset = rng.normal(size=(2, 3)), rng.normal(size=2)
    curve, t = make(POINTS), np.linspace(0.0, 3.0, 31)
    expected = curve.evaluate(t) @ matrix.T + offset
    np.testing.assert_allclose(make(POINTS @ matrix.T + offset).evaluate(t), expected, atol=1e-10)
    moved = curve.transformed(matrix, offset)
    np.testing.assert_allclose(moved.evaluate(t), expected, atol=1e-10)
    np.testing.assert_allclose(moved.evaluate(t, 1), curve.evaluate(t, 1) @ matrix.T, atol=1e-8)


def test_slower_by_a_factor_divides_derivatives_by_its_powers(make):
    curve, t = make(POINTS), inner_times(make(POINTS))
    slow = curve.rescaled(2.0)
    for order in range(4):
        expected = curve.evaluate(t, order) / 2.0**order
        np.testing.assert_allclose(
            slow.evaluate(2.0 * t, order), expected, atol=1e-9 * (1.0 + np.abs(expected).max())
        )


def test_times_that_are_no_times_of_the_curve_are_refused(make):
    curve = make(POINTS)
    for wrong in ([-0.1], [3.1], [np.nan], "x", [[0.0]], np.inf):
        refused("t:", curve.evaluate, wrong)
    for wrong in (-1, 1.5, True):
        refused("derivative", curve.evaluate, 0.0, wrong)
    assert curve.evaluate([]).shape == (0, 3)
    np.testing.assert_allclose(curve.evaluate(3.0 + 1e-12), curve.evaluate(3.0), rtol=1e-12)


def test_curves_are_frozen_and_survive_pickling(make):
    points = POINTS.copy()
    curve = make(points)
    before = curve.evaluate(1.3)
    points[:] = 0.0
    assert (curve.evaluate(1.3) == before).all()
    assert (pickle.loads(pickle.dumps(curve)).evaluate(1.3) == before).all()
    with pytest.raises(AttributeError):
        curve.points = points


def test_wrong_points_are_refused(make):
    for wrong in (np.full((6, 3), np.nan), np.empty((0, 3)), "points", np.zeros((2, 2, 2))):
        with pytest.raises((InvalidInput, TypeError, AttributeError, IndexError)):
            make(wrong)


@pytest.mark.parametrize("times", [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, np.nan, 1.0], [0.0], []])
def test_times_that_do_not_rise_are_refused(times):
    points = np.zeros((len(times), 2))
    for build in (
        tr.linear,
        tr.natural_cubic,
        tr.clamped_cubic,
        tr.minimum_jerk_through,
        tr.Lagrange,
    ):
        with pytest.raises(InvalidInput):
            build(times, points)
