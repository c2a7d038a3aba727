"""Properties of polynomials, splines, Bezier curves and B-splines, as in the notes."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BPoly, CubicSpline, make_lsq_spline

from leadthrough import trajectories as tr
from leadthrough.trajectories import Nurbs, bspline_near, nurbs_through

RNG = np.random.default_rng(3)
TIMES = np.array([-1.0, -0.3, 0.1, 0.4, 1.0, 1.3])
FINE = np.linspace(-1.0, 1.3, 200)


def values(coefficients, t, order=0):
    return np.column_stack([np.polynomial.Polynomial(c).deriv(order)(t) for c in coefficients.T])


@pytest.mark.parametrize(
    ("degree", "build"),
    [
        (5, lambda x, *_: tr.Lagrange(TIMES, x)),
        (11, lambda x, v: tr.osculating(TIMES, x, v)),
        (1, lambda x, *_: tr.linear(TIMES, x)),
        (3, lambda x, v: tr.hermite(TIMES, x, v)),
        (3, lambda x, v: tr.clamped_cubic(TIMES, x, start_velocity=v[0], end_velocity=v[-1])),
        (1, lambda x, *_: tr.natural_cubic(TIMES, x)),
        (2, lambda x, *_: tr.smooth(TIMES, x, continuity=4, ends="natural")),
        (1, lambda x, *_: tr.smoothing(TIMES, x, weight=5.0)),
    ],
)
def test_polynomials_are_met_exactly(degree, build):
    coefficients = RNG.normal(size=(degree + 1, 2))
    x, v = values(coefficients, TIMES), values(coefficients, TIMES, 1)
    curve = build(x, v)
    scale = np.abs(values(coefficients, FINE)).max()
    np.testing.assert_allclose(curve.evaluate(FINE), values(coefficients, FINE), atol=1e-9 * scale)


def test_lagrange_s_polynomials_are_a_partition_of_unity_and_one_at_their_own_node():
    through = tr.Lagrange(TIMES, TIMES[:, None])
    np.testing.assert_allclose(through.basis(TIMES), np.eye(6), atol=1e-15)
    np.testing.assert_allclose(through.basis(FINE).sum(axis=1), 1.0, rtol=1e-12)


def test_even_nodes_swing_on_runge_s_function_and_chebyshev_s_do_not():
    def runge(t):
        return 1.0 / (1.0 + 25.0 * t**2)

    t = np.linspace(-1.0, 1.0, 2001)
    errors = {}
    for count in (11, 21, 41):
        for name, nodes in (
            ("even", np.linspace(-1.0, 1.0, count)),
            ("chebyshev", tr.chebyshev_nodes(count)),
        ):
            found = tr.Lagrange(nodes, runge(nodes)).evaluate(t)[:, 0]
            errors[name, count] = np.abs(found - runge(t)).max()
    assert errors["even", 11] < errors["even", 21] < errors["even", 41]
    assert errors["even", 41] > 1e4
    assert errors["chebyshev", 41] < 1e-3 < errors["chebyshev", 11]


def test_a_polynomial_of_two_nodes_has_its_values_there_without_a_warning():
    assert tr.Lagrange([0.0, 2.0], [[3.0], [4.0]]).evaluate([0.0, 1.0, 2.0]).T.tolist() == [
        [3.0, 3.5, 4.0]
    ]


def test_osculating_polynomials_have_the_given_values_and_velocities():
    x, v = RNG.normal(size=(2, 6, 3))
    curve = tr.osculating(TIMES, x, v)
    np.testing.assert_allclose(curve.evaluate(TIMES), x, atol=1e-10)
    np.testing.assert_allclose(curve.evaluate(TIMES, 1), v, atol=1e-9)


@pytest.mark.parametrize("continuity", range(8))
@pytest.mark.parametrize("ends", ["rest", "natural"])
def test_splines_are_as_smooth_as_asked_and_no_smoother(continuity, ends):
    x = RNG.normal(size=(6, 2))
    curve = tr.smooth(TIMES, x, continuity=continuity, ends=ends)
    np.testing.assert_allclose(curve.evaluate(TIMES), x, atol=1e-10)
    assert curve.degree == continuity + 1
    assert (curve.smoothness(tolerance=1e-6) == continuity + 1).all()
    first, last = curve.domain
    for time, count in ((first, (continuity + 1) // 2), (last, continuity // 2)):
        orders = (
            range(1, count + 1) if ends == "rest" else range(continuity, continuity - count, -1)
        )
        for order in orders:
            size = np.abs(curve.coefficients[:, order]).max()
            np.testing.assert_allclose(
                curve.evaluate(time, order), 0.0, atol=1e-8 * (1 + 1000 * size)
            )


def test_cubics_are_scipy_s():
    x = RNG.normal(size=(6, 2))
    for ours, ends in (
        (tr.natural_cubic(TIMES, x), "natural"),
        (tr.clamped_cubic(TIMES, x), "clamped"),
        (tr.periodic_cubic(TIMES, np.vstack([x[:-1], x[:1]])), "periodic"),
    ):
        points = np.vstack([x[:-1], x[:1]]) if ends == "periodic" else x
        theirs = CubicSpline(TIMES, points, bc_type=ends)
        for order in range(4):
            t = FINE[:-1] + 1e-4
            np.testing.assert_allclose(ours.evaluate(t, order), theirs(t, order), atol=1e-9)
            same = tr.Spline(theirs.x, theirs.c[::-1].transpose(1, 0, 2))
            for each in (t, t[::-1], TIMES):
                expected = theirs(each, order, extrapolate=False)
                np.testing.assert_array_equal(same.evaluate(each, order), expected)


def test_accelerations_given_at_the_ends_are_met():
    x = RNG.normal(size=(6, 2))
    curve = tr.natural_cubic(TIMES, x, start_acceleration=[1.0, 2.0], end_acceleration=-3.0)
    np.testing.assert_allclose(curve.evaluate(-1.0, 2), [1.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(curve.evaluate(1.3, 2), [-3.0, -3.0], atol=1e-12)


def test_a_bezier_curve_stays_in_the_hull_and_begins_towards_its_second_point():
    points = RNG.normal(size=(6, 2))
    curve = tr.Bezier(points, (1.0, 3.0))
    x = curve.evaluate(np.linspace(1.0, 3.0, 100))
    for direction in RNG.normal(size=(20, 2)):
        assert (x @ direction).max() <= (points @ direction).max() + 1e-12
    np.testing.assert_allclose(curve.evaluate(1.0, 1), 5.0 / 2.0 * (points[1] - points[0]))
    np.testing.assert_allclose(curve.evaluate(3.0, 1), 5.0 / 2.0 * (points[-1] - points[-2]))


def test_bezier_constructions_agree():
    points = RNG.normal(size=(5, 3))
    curve, t = tr.Bezier(points, (0.0, 2.0)), np.linspace(0.0, 2.0, 41)
    for time in t:
        np.testing.assert_allclose(
            tr.de_casteljau(points, time / 2.0)[-1][0], curve.evaluate(time), atol=1e-12
        )
    np.testing.assert_allclose(curve.elevated().evaluate(t), curve.evaluate(t), atol=1e-12)
    np.testing.assert_allclose(curve.derived().evaluate(t), curve.evaluate(t, 1), atol=1e-12)
    np.testing.assert_allclose(curve.spline().evaluate(t), curve.evaluate(t), atol=1e-12)
    before, after = curve.split(0.7)
    for part in (before, after):
        inside = t[(t >= part.domain[0]) & (t <= part.domain[1])]
        np.testing.assert_allclose(part.evaluate(inside), curve.evaluate(inside), atol=1e-12)


def test_b_splines_add_up_to_one_and_include_the_end_of_their_domain():
    knots = [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 2.0, 2.0, 2.0]
    curve = tr.BSpline(RNG.normal(size=(6, 2)), knots, 2)
    basis = curve.basis(np.linspace(0.0, 2.0, 50))
    np.testing.assert_allclose(basis.sum(axis=1), 1.0, rtol=1e-12)
    assert (basis >= 0.0).all()
    np.testing.assert_allclose(curve.evaluate(2.0), curve.points[-1])
    t = np.linspace(0.0, 2.0, 77)
    np.testing.assert_allclose(curve.spline().evaluate(t), curve.evaluate(t), atol=1e-12)


def test_a_nurbs_of_degree_two_is_a_circle():
    corner = 0.5**0.5
    circle = tr.Nurbs(
        [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0]],
        [1, corner, 1, corner, 1],
        [0, 0, 0, 1, 1, 2, 2, 2],
        2,
    )
    t = np.linspace(0.0, 2.0, 100)
    np.testing.assert_allclose(np.linalg.norm(circle.evaluate(t), axis=1), 1.0, rtol=1e-14)
    assert np.abs(np.sum(circle.evaluate(t) * circle.evaluate(t, 1), axis=1)).max() < 1e-13


def test_minimum_jerk_meets_its_boundary_conditions_and_beats_its_neighbours():
    x = RNG.normal(size=(6, 2))
    curve = tr.minimum_jerk(tr.State(*x[:3]), tr.State(*x[3:]), duration=1.7)
    for i, (time, order) in enumerate((t, k) for t in (0.0, 1.7) for k in range(3)):
        np.testing.assert_allclose(curve.evaluate(time, order), x[i], atol=1e-12)

    def cost(bump):  # a change that keeps all six conditions: t^3 (T - t)^3
        change = np.polynomial.Polynomial([0, 0, 0, 1]) * np.polynomial.Polynomial([1.7, -1]) ** 3
        third = change.deriv(3)
        return quad(lambda t: (curve.evaluate(t, 3)[0] + bump * third(t)) ** 2, 0.0, 1.7)[0]

    assert cost(0.0) < min(cost(0.1), cost(-0.1))


def test_the_rise_of_minimum_jerk_is_its_curve_from_zero_to_a_height():
    u = np.linspace(0.0, 1.0, 11)
    curve = tr.minimum_jerk([0.0], [2.5], duration=1.0)
    assert np.allclose(
        tr.minimum_jerk_time_scaling(u, 2.5), curve.evaluate(u)[:, 0], rtol=0.0, atol=1e-14
    )
    assert np.array_equal(tr.minimum_jerk_time_scaling(np.array([0.0, 0.5, 1.0])), [0.0, 0.5, 1.0])


def test_minimum_jerk_through_points_is_four_times_continuous_and_at_rest():
    x = RNG.normal(size=(6, 2))
    curve = tr.minimum_jerk_through(TIMES, x)
    assert (curve.smoothness(tolerance=1e-7) >= 5).all()
    for order in (1, 2):
        np.testing.assert_allclose(curve.evaluate(curve.domain, order), 0.0, atol=1e-9)
    moving = tr.minimum_jerk_through(TIMES, x, start=tr.State(x[0], [1.0, 2.0], 3.0))
    np.testing.assert_allclose(moving.evaluate(-1.0, 1), [1.0, 2.0], atol=1e-10)
    np.testing.assert_allclose(moving.evaluate(-1.0, 2), [3.0, 3.0], atol=1e-9)


@pytest.mark.parametrize("length", [1e-4, 0.01, 0.1, 0.4, 0.5, 0.6, 2.0, 30.0])
def test_profiles_use_their_limits_and_no_more(length):
    limits = {"velocity": 1.0, "acceleration": 2.0}
    for curve, rates, order in (
        (tr.trapezoid([1.0], [1.0 - length], **limits), (1.0, 2.0), 2),
        (tr.double_s([1.0], [1.0 - length], **limits, jerk=10.0), (1.0, 2.0, 10.0), 3),
    ):
        t = np.linspace(*curve.domain, 4001)
        np.testing.assert_allclose(
            curve.evaluate(curve.domain)[:, 0], [1.0, 1.0 - length], atol=1e-12
        )
        used = [np.abs(curve.evaluate(t, k)).max() / rate for k, rate in enumerate(rates, 1)]
        assert max(used) == pytest.approx(1.0, abs=1e-9)
        assert (curve.smoothness(tolerance=1e-7) >= order).all()
        for k in range(1, order):
            np.testing.assert_allclose(curve.evaluate(curve.domain, k), 0.0, atol=1e-9)


def test_long_moves_take_the_time_of_the_books():
    slow = tr.trapezoid([0.0, 0.0], [2.0, -1.0], velocity=1.0, acceleration=2.0)
    assert slow.domain[1] == pytest.approx(2.0 / 1.0 + 1.0 / 2.0)
    gentle = tr.double_s([0.0], [2.0], velocity=1.0, acceleration=2.0, jerk=10.0)
    assert gentle.domain[1] == pytest.approx(2.0 + 1.0 / 2.0 + 2.0 / 10.0)


def test_beziers_are_scipy_s():
    points = RNG.normal(size=(7, 7))
    theirs = BPoly(points[:, None], [0.0, 1.0])
    t = np.linspace(0.0, 1.0, 50)
    np.testing.assert_allclose(tr.Bezier(points).evaluate(t, 2), theirs(t, 2), atol=1e-11)


T = np.linspace(0.0, 2.0, 81)
NOISE = np.random.default_rng(0)
NOISY = np.column_stack([np.sin(3 * T), np.cos(2 * T), T]) + 0.01 * NOISE.normal(size=(81, 3))


@pytest.mark.parametrize("degree", [2, 3, 5])
def test_fewer_control_points_come_nearer_the_more_there_are_and_meet_the_ends(degree):
    errors = []
    for count in (8, 12, 30, 81):
        made = bspline_near(T, NOISY, control_points=count, degree=degree)
        assert made.points.shape == (count, 3)
        np.testing.assert_allclose(made.evaluate(T[[0, -1]]), NOISY[[0, -1]], atol=1e-12)
        errors.append(float(((made.evaluate(T) - NOISY) ** 2).sum()))
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-18  # as many as points: through all of them


def test_error_is_hardly_more_than_that_of_least_squares_with_free_ends():
    made = bspline_near(T, NOISY, control_points=14)
    free = make_lsq_spline(T, NOISY, made.knot_vector, 3)
    ours = ((made.evaluate(T) - NOISY) ** 2).sum()
    best = ((free(T) - NOISY) ** 2).sum()
    assert best <= ours < 1.2 * best


def test_rational_spline_passes_all_points_and_is_an_exact_quarter_circle():
    weights = NOISE.uniform(0.5, 2.0, 81)
    made = nurbs_through(T, NOISY, weights=weights)
    np.testing.assert_allclose(made.evaluate(T), NOISY, atol=1e-9)
    corner = [1.0, np.sqrt(0.5), 1.0]
    circle = Nurbs([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], corner, [0, 0, 0, 1, 1, 1], 2)
    times = np.array([0.0, 0.4, 1.0])
    again = nurbs_through(times, circle.evaluate(times), weights=corner, degree=2)
    np.testing.assert_allclose(again.points, circle.points, atol=1e-12)
    there = again.evaluate(np.linspace(0.0, 1.0, 20))
    np.testing.assert_allclose(np.linalg.norm(there, axis=1), 1.0, atol=1e-12)
