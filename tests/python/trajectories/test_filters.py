"""Filters: limits are kept, targets reached, nothing chatters."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadthrough import trajectories as tr
from leadthrough.errors import InvalidInput

CASES = 100_000  # of one dimension each, filtered side by side


def state(x, v):
    return tr.FilterState(np.array(x), np.array(v), np.zeros_like(np.array(x)))


def test_a_still_target_is_approached_as_the_differential_equation_says():
    for made, equation in (
        (tr.FirstOrderFilter(3.0), lambda _, y: [-3.0 * (y[0] - 1.0), 0.0]),
        (tr.SecondOrderFilter(9.0, 6.0), lambda _, y: [y[1], 9.0 * (1.0 - y[0]) - 6.0 * y[1]]),
        (tr.SecondOrderFilter(9.0, 1.0), lambda _, y: [y[1], 9.0 * (1.0 - y[0]) - 1.0 * y[1]]),
        (tr.SecondOrderFilter(9.0, 20.0), lambda _, y: [y[1], 9.0 * (1.0 - y[0]) - 20.0 * y[1]]),
    ):
        now, times = tr.FilterState.at_rest([0.0]), np.arange(1, 31) * 0.1
        found = []
        for _ in times:
            now = made.step(now, [1.0], 0.1)
            found.append(now.position[0])
        truth = solve_ivp(equation, (0.0, 3.0), [0.0, 0.0], t_eval=times, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(found, truth.y[0], atol=1e-8)


@pytest.mark.parametrize("made", [tr.FirstOrderFilter(5.0), tr.SecondOrderFilter(25.0, 10.0)])
def test_with_its_velocity_a_moving_target_is_followed_without_lag(made):
    now = state([2.0, 0.0], [1.5, -0.5])
    for k in range(1, 50):
        target = np.array([2.0, 0.0]) + 0.01 * k * np.array([1.5, -0.5])
        now = made.step(now, target, 0.01, velocity=[1.5, -0.5])
        np.testing.assert_allclose(now.position, target, atol=1e-12)


@pytest.mark.parametrize("period", [1e-3, 10.0, 1e3])
def test_linear_filters_are_stable_at_any_period(period):
    for made in (tr.FirstOrderFilter(50.0), tr.SecondOrderFilter(900.0, 60.0)):
        now = tr.FilterState.at_rest([-4.0])
        for _ in range(2000):
            now = made.step(now, [1.0], period)
        np.testing.assert_allclose(now.position, 1.0, atol=1e-9)


def test_a_hundred_thousand_random_moves_keep_their_limits_and_come_to_rest():
    rng = np.random.default_rng(0)
    limits, period = 10.0 ** rng.uniform(0, 1.3, (2, CASES)), 0.05
    now = state(rng.normal(size=CASES), rng.uniform(-1.0, 1.0, CASES) * limits[0])
    for change in range(4):
        target = rng.uniform(-1.0, 1.0, CASES) * 10.0 ** rng.uniform(-3, 0.7, CASES)
        for _ in range(15 if change < 3 else 2000):
            before, now = now, tr.TimeOptimalFilter(*limits).step(now, target, period)
            assert (np.abs(now.velocity) <= limits[0] + 1e-9).all()
            assert (np.abs(now.velocity - before.velocity) <= limits[1] * period + 1e-9).all()
            mean = 0.5 * (now.velocity + before.velocity) * period
            assert np.abs(now.position - before.position - mean).max() < 1e-9
            if change < 3:
                continue
            done = (now.position == target) & (now.velocity == 0.0)
            there = tr.FilterState.at_rest(target[done])  # and stays there, as one more step shows
            again = tr.TimeOptimalFilter(*limits[:, done]).step(there, target[done], period)
            assert (again.position == target[done]).all()
            assert not again.velocity.any()
            assert not again.acceleration.any()
            limits, target = limits[:, ~done], target[~done]
            now = state(now.position[~done], now.velocity[~done])
            if done.all():
                return
    pytest.fail(f"{len(target)} never came to rest")


def test_from_rest_no_move_passes_its_target_or_changes_its_mind():
    rng = np.random.default_rng(1)
    top, push = 10.0 ** rng.uniform(-1, 1, (2, CASES))
    made = tr.TimeOptimalFilter(top, push)
    now, target = tr.FilterState.at_rest(np.zeros(CASES)), rng.normal(size=CASES)
    signs, last = np.zeros(CASES), np.zeros(CASES)
    for _ in range(75):
        now = made.step(now, target, 0.1)
        assert ((target - now.position) * np.sign(target) >= -1e-12).all()
        moving = np.abs(now.acceleration) > 1e-6 * push
        signs += moving & (np.sign(now.acceleration) * last < 0.0)
        last = np.where(moving, np.sign(now.acceleration), last)
    assert signs.max() <= 1  # speeds up, brakes, and that is all


def test_the_time_is_nearly_that_of_the_bang_bang_law():
    made, now, period = tr.TimeOptimalFilter(1.0, 2.0), tr.FilterState.at_rest([0.0]), 1e-3
    steps = 0
    while now.position[0] != 2.0:
        now, steps = made.step(now, [2.0], period), steps + 1
    assert steps * period == pytest.approx(
        tr.trapezoid([0.0], [2.0], velocity=1.0, acceleration=2.0).domain[1], abs=5e-3
    )


def test_a_speed_above_a_lowered_limit_falls_to_it():
    now, made = state([0.0], [5.0]), tr.TimeOptimalFilter(1.0, 2.0)
    speeds = []
    for _ in range(60):
        now = made.step(now, [100.0], 0.1)
        speeds.append(now.velocity[0])
    np.testing.assert_allclose(np.diff(speeds[:20]), -0.2, atol=1e-12)
    assert speeds[-1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: tr.FirstOrderFilter(0.0),
        lambda: tr.SecondOrderFilter(1.0, np.nan),
        lambda: tr.TimeOptimalFilter(1.0, [-1.0]),
        lambda: tr.TimeOptimalFilter([[1.0]], 1.0),
        lambda: tr.TimeOptimalFilter([1.0, 2.0], 1.0).step(
            tr.FilterState.at_rest([0.0]), [1.0], 0.1
        ),
        lambda: tr.TimeOptimalFilter(1.0, 1.0).step(tr.FilterState.at_rest([0.0]), [np.nan], 0.1),
        lambda: tr.TimeOptimalFilter(1.0, 1.0).step(tr.FilterState.at_rest([0.0]), [1.0], 0.0),
        lambda: tr.TimeOptimalFilter(1.0, 1.0).step("state", [1.0], 0.1),
        lambda: tr.FilterState.at_rest(3.0),
    ],
)
def test_wrong_input_is_refused(wrong):
    with pytest.raises(InvalidInput):
        wrong()
