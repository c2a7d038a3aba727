"""B-splines near and through points: against least squares of SciPy, and a circle."""

import numpy as np
import pytest
from scipy.interpolate import make_lsq_spline

from leadthrough.errors import InvalidInput
from leadthrough.trajectories import Nurbs, bspline_near, nurbs_through

T = np.linspace(0.0, 2.0, 81)
RNG = np.random.default_rng(0)
NOISY = np.column_stack([np.sin(3 * T), np.cos(2 * T), T]) + 0.01 * RNG.normal(size=(81, 3))


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
    weights = RNG.uniform(0.5, 2.0, 81)
    made = nurbs_through(T, NOISY, weights=weights)
    np.testing.assert_allclose(made.evaluate(T), NOISY, atol=1e-9)
    corner = [1.0, np.sqrt(0.5), 1.0]
    circle = Nurbs([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], corner, [0, 0, 0, 1, 1, 1], 2)
    times = np.array([0.0, 0.4, 1.0])
    again = nurbs_through(times, circle.evaluate(times), weights=corner, degree=2)
    np.testing.assert_allclose(again.points, circle.points, atol=1e-12)
    there = again.evaluate(np.linspace(0.0, 1.0, 20))
    np.testing.assert_allclose(np.linalg.norm(there, axis=1), 1.0, atol=1e-12)


def test_what_cannot_be_fitted_is_refused_by_name():
    with pytest.raises(InvalidInput, match="control_points"):
        bspline_near(T, NOISY, control_points=3)
    with pytest.raises(InvalidInput, match="weights"):
        nurbs_through(T, NOISY, weights=-np.ones(81))
    with pytest.raises(InvalidInput, match="times"):
        bspline_near(T[::-1], NOISY, control_points=10)
