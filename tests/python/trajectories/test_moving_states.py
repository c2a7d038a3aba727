"""Between moving states: Bezier pieces joined C^m, trapezoid and double S, a target that moves."""

import numpy as np
import pytest
import ruckig
from scipy.interpolate import BPoly

from leadthrough import trajectories as tr
from leadthrough.errors import InvalidInput

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


def test_pieces_that_do_not_meet_are_refused():
    piece = tr.Bezier([[0.0, 0.0], [1.0, 1.0]])
    with pytest.raises(InvalidInput, match=r"pieces\[1\]: expected a curve from where and when"):
        tr.joined([piece, tr.Bezier([[1.0, 2.0], [2.0, 2.0]], (1.0, 2.0))])
    with pytest.raises(InvalidInput, match="pieces: expected at least one"):
        tr.joined([])
    with pytest.raises(InvalidInput, match="points: expected 2 columns"):
        piece.continued([[1.0, 2.0, 3.0]], duration=1.0)


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
    for wrong, told in (
        ({"start_velocity": [1.0, 1.0]}, "along the line"),
        ({"end_velocity": 2.0 * way}, "at most the limit"),
        ({"end_velocity": 1.0}, r"expected a velocity \(2,\)"),
    ):
        with pytest.raises(InvalidInput, match=told):
            tr.double_s([0.0, 0.0], way, **LIMITS, **wrong)


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
    """Where both speeds are alike, the peak is nearer to them than their digits tell."""
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
