"""Curves run by laws, and time laws between moving states."""

import sys

import numpy as np
import pytest
import ruckig
from scipy.interpolate import BPoly

from leadthrough import rotations, trajectories as tr
from leadthrough.errors import MissingDependency
from leadthrough.trajectories import (
    Bezier,
    PoseCurve,
    RotationSpline,
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


LIMITS = {"velocity": 2.0, "acceleration": 3.0, "jerk": 8.0}


@pytest.mark.parametrize("continuity", [0, 1, 2, 4])
def test_a_bezier_curve_is_continued_with_as_many_derivatives_as_asked_for(continuity):
    rng = np.random.default_rng(continuity)
    first = tr.Bezier(rng.normal(size=(6, 3)), (0.5, 2.0))
    second = first.continued(rng.normal(size=(2, 3)), duration=0.7, continuity=continuity)
    third = second.continued(rng.normal(size=(1, 3)), duration=2.0, continuity=continuity)
    curve = tr.joined([first, second, third])
    assert curve.domain == pytest.approx((0.5, 4.7))
    for before, after in ((first, second), (second, third)):
        # SciPy's Bernstein polynomials of the same control points.
        pieces = [BPoly(each.points[:, None], each.domain) for each in (before, after)]
        for k in range(continuity + 1):
            left, right = (each(before.domain[1], nu=k) for each in pieces)
            np.testing.assert_allclose(right, left, rtol=1e-9, atol=1e-9 * 10.0**k)
    times = np.linspace(2.0, 2.69, 9)
    np.testing.assert_allclose(curve.evaluate(times, 1), second.evaluate(times, 1), atol=1e-9)


def cases(count):
    rng = np.random.default_rng(0)
    lengths = rng.normal(size=count) * 10.0 ** rng.uniform(-2.0, 0.7, count)
    speeds = LIMITS["velocity"] * rng.uniform(-1.0, 1.0, (count, 2))
    speeds[::4, 1] = 0.0
    speeds[1::4, 0] = 0.0
    return zip(lengths, *speeds.T, strict=True)


def fastest(length, first, last, jerk):
    """The duration that ruckig finds."""
    task = ruckig.InputParameter(1)
    task.current_position, task.current_velocity = [0.0], [first]
    task.target_position, task.target_velocity = [length], [last]
    task.max_velocity, task.max_acceleration = [LIMITS["velocity"]], [LIMITS["acceleration"]]
    task.max_jerk = [jerk]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(task, found)
    return found.duration


@pytest.mark.parametrize("name", ["trapezoid", "double_s"])
def test_moves_between_moving_states_take_the_least_time_inside_their_limits(name):
    kept = ["velocity", "acceleration", *(["jerk"] if name == "double_s" else [])]
    limits = {key: LIMITS[key] for key in kept}
    for length, first, last in cases(400):
        move = getattr(tr, name)(
            [0.0], [length], **limits, start_velocity=[first], end_velocity=[last]
        )
        end = move.domain[1]
        ends = np.array([0.0, end])
        np.testing.assert_allclose(move.evaluate(ends)[:, 0], [0.0, length], atol=1e-7)
        np.testing.assert_allclose(move.evaluate(ends, 1)[:, 0], [first, last], atol=1e-7)
        middles = 0.5 * (move.knots[1:] + move.knots[:-1])
        at = np.concatenate([move.knots, middles])
        for order, key in enumerate(kept, start=1):
            where = middles if order == len(kept) else at
            assert np.abs(move.evaluate(where, order)).max() <= limits[key] * (1.0 + 1e-7)
        best = fastest(length, first, last, limits.get("jerk", np.inf))
        assert end <= best * (1.0 + 1e-6) + 1e-6, (length, first, last)
        assert end >= best * (1.0 - 1e-6) - 1e-6, (length, first, last)


def test_several_dimensions_stay_on_their_line():
    way = np.array([3.0, -4.0])
    move = tr.double_s([1.0, 1.0], way + 1.0, **LIMITS, start_velocity=0.2 * way)
    at = move.evaluate(np.linspace(*move.domain, 50)) - 1.0
    np.testing.assert_allclose(at @ [4.0, 3.0], 0.0, atol=1e-12)
    again = tr.trapezoid([1.0], [1.0], velocity=1.0, acceleration=2.0, start_velocity=[1.0])
    assert again.evaluate(again.domain[1])[0] == pytest.approx(1.0)  # past it and back


def test_a_moving_target_is_caught_in_the_least_time_and_then_followed_exactly():
    filter_, period = tr.TimeOptimalFilter(2.0, 3.0), 1e-3
    for away, drift in ((1.0, 0.5), (-1.0, 0.5), (0.3, -1.5), (-0.2, 1.9)):
        now, caught = tr.FilterState.at_rest([0.0]), None
        for k in range(1, 6000):
            target = away + drift * period * k
            before, now = now, filter_.step(now, [target], period, velocity=[drift])
            assert abs(now.velocity[0]) <= 2.0 + 1e-9
            assert abs(now.velocity[0] - before.velocity[0]) <= 3.0 * period + 1e-9
            there = abs(now.position[0] - target) < 1e-12 and abs(now.velocity[0] - drift) < 1e-9
            assert there or caught is None
            if there and caught is None:
                caught = period * k
        assert caught is not None
        # In the target's frame: from the other's speed to rest, unless it passes the target first.
        side = np.sign(away)
        if -side * drift < 0.0 or drift**2 / 6.0 < abs(away):
            bound = {"velocity": 2.0 - side * drift, "acceleration": 3.0}
            best = tr.trapezoid([0.0], [away], **bound, start_velocity=[-drift]).domain[1]
            assert caught == pytest.approx(best, abs=5 * period)


@pytest.mark.parametrize("exponent", range(-12, 0))
@pytest.mark.parametrize("speed", [-2.0, -0.7, 0.3, 2.0])
@pytest.mark.parametrize("last", [1.0, 0.999999999])
def test_a_short_way_is_met_to_its_own_digits_at_any_speed(exponent, speed, last):
    """If both speeds are alike, the peak differs from them by less than their digits."""
    for length in (10.0**exponent, -(10.0**exponent)):
        for make, limits in ((tr.trapezoid, {"velocity", "acceleration"}), (tr.double_s, LIMITS)):
            given = {name: LIMITS[name] for name in limits}
            move = make(
                [0.0], [length], start_velocity=[speed], end_velocity=[last * speed], **given
            )
            took = move.domain[1]
            reached = move.evaluate(took)[0]
            assert reached == pytest.approx(length, abs=1e-11 * max(abs(length), 2.0 * took))
            assert move.evaluate(took, 1)[0] == pytest.approx(last * speed, abs=1e-7)
            if length * speed > 0.0 and last == 1.0:  # else the change of speed takes longer
                assert took <= abs(length / speed) * (1.0 + 1e-9)
                if speed in (-2.0, 2.0):
                    assert took >= abs(length / speed) * (1.0 - 1e-9)


RUCKIG_LIMITS = {"velocity": [1.0, 2.0, 0.5], "acceleration": 3.0, "jerk": 20.0}


def test_it_meets_both_states_and_keeps_the_limits():
    pytest.importorskip("ruckig")
    rng = np.random.default_rng(0)
    for _ in range(50):
        start = tr.State(rng.normal(size=3), rng.uniform(-0.4, 0.4, 3), rng.uniform(-1, 1, 3))
        end = tr.State(rng.normal(size=3), rng.uniform(-0.4, 0.4, 3))
        curve = tr.point_to_point(start, end, **RUCKIG_LIMITS)
        for time, wanted in zip(curve.domain, (start, end), strict=True):
            np.testing.assert_allclose(curve.evaluate(time), wanted.position, atol=1e-8)
            np.testing.assert_allclose(curve.evaluate(time, 1), wanted.velocity, atol=1e-8)
            rate = np.broadcast_to(wanted.acceleration, 3)
            np.testing.assert_allclose(curve.evaluate(time, 2), rate, atol=1e-8)
        t = np.linspace(*curve.domain, 500)
        for order, limit in enumerate(([1.0, 2.0, 0.5], 3.0, 20.0), 1):
            assert (np.abs(curve.evaluate(t, order)) <= np.array(limit) + 1e-6).all()
        assert (curve.smoothness(tolerance=1e-6) >= 3).all()


def test_from_rest_to_rest_it_is_the_double_s():
    pytest.importorskip("ruckig")
    limits = {"velocity": 1.0, "acceleration": 2.0, "jerk": 10.0}
    for length in (0.01, 0.5, 3.0):
        found = tr.point_to_point([0.0], [length], **limits)
        assert found.domain[1] == pytest.approx(tr.double_s([0.0], [length], **limits).domain[1])


def test_without_ruckig_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(MissingDependency, match=r"leadthrough\[ruckig\]"):
        tr.point_to_point([0.0], [1.0], velocity=1.0, acceleration=1.0, jerk=1.0)
