"""Curves run by laws: exact derivatives, for points, rotations and poses."""

import numpy as np
import pytest

from leadthrough import rotations
from leadthrough.errors import InvalidInput
from leadthrough.trajectories import (
    Bezier,
    PoseCurve,
    RotationSpline,
    Spline,
    double_s,
    minimum_jerk,
    natural_cubic,
    run_by,
    trapezoid,
)

LAWS = {
    "trapezoid": trapezoid([0.0], [1.0], velocity=0.8, acceleration=2.0),
    "double S": double_s([0.0], [1.0], velocity=0.8, acceleration=2.0, jerk=20.0),
    "minimum jerk": minimum_jerk([0.0], [1.0], duration=2.0),
}
PATH = Bezier([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5], [2.0, -1.0, 1.0], [3.0, 0.0, 0.0]])
TURNED = RotationSpline(
    [0.0, 0.4, 1.0], rotations.exp([[0.0, 0.0, 0.0], [0.5, 0.2, 0.1], [0.2, 1.5, -0.4]])
)


@pytest.fixture(params=LAWS)
def law(request):
    return LAWS[request.param]


def inside(law, count=40):
    first, last = law.domain
    return first + (last - first) * (np.arange(count) + 0.5) / count


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_derivatives_of_a_polynomial_path_are_those_of_the_polynomial_in_time(order):
    """Of polynomials, f(s(t)) is a polynomial too, whose derivatives are known otherwise."""
    law = minimum_jerk([0.0], [1.0], duration=2.0)
    made = run_by(PATH, law)
    ts = np.linspace(0.0, 2.0, 40)
    fits = [np.polynomial.Polynomial.fit(ts, x, 15) for x in made.evaluate(ts).T]
    exact = np.column_stack([fit.deriv(order)(ts) for fit in fits])
    np.testing.assert_allclose(made.evaluate(ts, order), exact, atol=1e-6)


def test_speed_along_the_path_is_the_laws_and_the_ends_are_met(law):
    made = run_by(PATH, law)
    assert made.domain == law.domain
    np.testing.assert_allclose(made.evaluate(law.domain[1]), [3.0, 0.0, 0.0], atol=1e-9)
    ts = inside(law)
    s = law.evaluate(ts)[:, 0]
    np.testing.assert_allclose(
        made.evaluate(ts, 1), PATH.evaluate(s, 1) * law.evaluate(ts, 1), atol=1e-12
    )


def test_rotations_have_the_derivatives_of_their_quaternions(law):
    made = run_by(TURNED, law)
    ts, h = inside(law), 1e-5
    ahead, behind = made.evaluate(ts + h), made.evaluate(ts - h)
    turned = rotations.log(rotations.compose(ahead, rotations.inverse(behind))) / (2 * h)
    np.testing.assert_allclose(made.evaluate(ts, 1), turned, atol=1e-5)
    slope = (made.evaluate(ts + h, 1) - made.evaluate(ts - h, 1)) / (2 * h)
    assert np.median(np.abs(made.evaluate(ts, 2) - slope)) < 1e-5


def test_poses_run_together_and_can_be_slowed_down(law):
    pose = PoseCurve(PATH, TURNED)
    made = run_by(pose, law)
    position, orientation = made.evaluate(inside(law))
    np.testing.assert_allclose(position, run_by(PATH, law).evaluate(inside(law)))
    np.testing.assert_allclose(orientation, run_by(TURNED, law).evaluate(inside(law)))
    slow = run_by(PATH, law).rescaled(2.0)
    np.testing.assert_allclose(
        slow.evaluate(2.0 * inside(law), 2), run_by(PATH, law).evaluate(inside(law), 2) / 4.0
    )
    moved = run_by(PATH, law).transformed(2.0 * np.eye(3), 1.0).transformed(np.eye(3)[:2], 0.5)
    np.testing.assert_allclose(moved.evaluate(0.3), 2.0 * made.evaluate(0.3)[0][:2] + 1.5)


def test_knots_are_where_law_or_path_have_theirs():
    law = LAWS["trapezoid"]
    path = natural_cubic([0.0, 0.3, 1.0], [[0.0], [1.0], [0.0]])
    knots = run_by(path, law).knots
    assert set(law.knots) <= set(knots)
    (passed,) = set(knots) - set(law.knots)
    np.testing.assert_allclose(law.evaluate(passed), 0.3, atol=1e-12)


def test_a_law_that_leaves_the_path_is_refused():
    beyond = trapezoid([0.0], [1.2], velocity=1.0, acceleration=1.0)
    with pytest.raises(InvalidInput, match=r"law: .*domain"):
        run_by(PATH, beyond)
    with pytest.raises(InvalidInput, match="law"):
        run_by(PATH, trapezoid([0.0, 0.0], [1.0, 1.0], velocity=1.0, acceleration=1.0))
    assert isinstance(LAWS["trapezoid"], Spline)
