"""Filters, also with bounded jerk: limits kept, targets reached, nothing chatters."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadthrough import trajectories as tr

CASES = 100_000  # of one dimension each, filtered side by side


def unaccelerated(x, v):
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
    now = unaccelerated([2.0, 0.0], [1.5, -0.5])
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
    now = unaccelerated(rng.normal(size=CASES), rng.uniform(-1.0, 1.0, CASES) * limits[0])
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
            now = unaccelerated(now.position[~done], now.velocity[~done])
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
    now, made = unaccelerated([0.0], [5.0]), tr.TimeOptimalFilter(1.0, 2.0)
    speeds = []
    for _ in range(60):
        now = made.step(now, [100.0], 0.1)
        speeds.append(now.velocity[0])
    np.testing.assert_allclose(np.diff(speeds[:20]), -0.2, atol=1e-12)
    assert speeds[-1] == pytest.approx(1.0)


LIMITS = [
    f"{rate}{side}" for side in ("", "_down") for rate in ("velocity", "acceleration", "jerk")
]


def test_a_target_faster_than_the_limit_is_left_behind_inside_the_limits():
    rng, count, period = np.random.default_rng(5), 2000, 0.05
    top, push = 10.0 ** rng.uniform(0.0, 1.3, (2, count))
    now = unaccelerated(rng.normal(size=count), rng.uniform(-1.0, 1.0, count) * top)
    drift, start = 3.0 * rng.uniform(-1.0, 1.0, count) * top, rng.normal(size=count)
    for k in range(1, 100):
        before, target = now, start + drift * period * k
        now = tr.TimeOptimalFilter(top, push).step(now, target, period, velocity=drift)
        assert (np.abs(now.velocity) <= top + 1e-9).all()
        assert (np.abs(now.velocity - before.velocity) <= push * period + 1e-9).all()


def state(x, v, a):
    return tr.FilterState(np.array(x), np.array(v), np.array(a))


def random_filter(rng, count):
    """Limits that are six different numbers in every dimension."""
    spans = [(0.0, 0.7), (0.3, 1.0), (1.0, 2.0)]
    up, down = ([10.0 ** rng.uniform(*span, count) for span in spans] for _ in range(2))
    return tr.JerkFilter(*up, *down)


def random_start(rng, made, count, *, beyond=1.0):
    """Moving states, up to `beyond` times the limits."""
    rates = []
    for up, down in (
        (made.velocity, made.velocity_down),
        (made.acceleration, made.acceleration_down),
    ):
        share = rng.uniform(-beyond, beyond, count)
        rates.append(share * np.where(share > 0.0, up, down))
    return state(rng.normal(size=count), *rates)


def released(made, now):
    """The velocity that is left when the acceleration is released as fast as it may."""
    jerk = np.where(now.acceleration > 0.0, made.jerk_down, -made.jerk)
    return now.velocity + 0.5 * now.acceleration**2 / jerk


def inside(made, now, slack=1e-9):
    """Where limits are kept and will be: also by the velocity that the acceleration leads to."""
    kept = np.ones(len(now.position), dtype=bool)
    for rate, up, down in (
        (now.velocity, made.velocity, made.velocity_down),
        (released(made, now), made.velocity, made.velocity_down),
        (now.acceleration, made.acceleration, made.acceleration_down),
    ):
        kept &= (rate <= up + slack) & (rate >= -down - slack)
    return kept


def keeps_its_jerk(made, before, now, period):
    jerk = (now.acceleration - before.acceleration) / period
    return ((jerk <= made.jerk + 1e-9) & (jerk >= -made.jerk_down - 1e-9)).all()


def rests(now, target):
    return (now.position == target) & (now.velocity == 0.0) & (now.acceleration == 0.0)


def of(made, rows):
    """The filter of some of the dimensions."""
    return tr.JerkFilter(*(getattr(made, name)[rows] for name in LIMITS))


def still_moving(made, now, target, period):
    """Filter, state and target of the dimensions that move; those at rest stay, as a step shows."""
    done = rests(now, target)
    again = of(made, done).step(tr.FilterState.at_rest(target[done]), target[done], period)
    assert rests(again, target[done]).all()
    moving = (x[~done] for x in vars(now).values())
    return of(made, ~done), state(*moving), target[~done]


def test_a_hundred_thousand_random_moves_keep_six_limits_and_come_to_rest():
    rng = np.random.default_rng(0)
    made, period = random_filter(rng, CASES), 0.1
    now = random_start(rng, made, CASES)
    now = state(now.position, now.velocity, np.where(inside(made, now), now.acceleration, 0.0))
    for change in range(4):
        target = rng.normal(size=CASES) * 10.0 ** rng.uniform(-3.0, 0.3, CASES)
        for _ in range(5 if change < 3 else 400):
            before, now = now, made.step(now, target, period)
            assert inside(made, now).all()
            assert keeps_its_jerk(made, before, now, period)
            if change == 3:
                made, now, target = still_moving(made, now, target, period)
            if not len(target):
                return
    pytest.fail(f"{len(target)} never came to rest")


def test_states_outside_of_the_limits_come_back_and_stay():
    rng = np.random.default_rng(1)
    made, period = random_filter(rng, 20_000), 0.1
    now, target = random_start(rng, made, 20_000, beyond=2.0), rng.normal(size=20_000)
    kept = inside(made, now)
    assert kept.mean() < 0.4
    for _ in range(1000):
        before, now = now, made.step(now, target, period)
        assert keeps_its_jerk(made, before, now, period)
        still = inside(made, now)
        assert still[kept].all()
        too_large = before.acceleration > made.acceleration + made.jerk_down * period
        fall = made.jerk_down * period
        np.testing.assert_allclose(
            (before.acceleration - now.acceleration)[too_large], fall[too_large], atol=1e-9
        )
        kept = still[~rests(now, target)]
        made, now, target = still_moving(made, now, target, period)
        if not len(target):
            return
    pytest.fail(f"{len(target)} never came to rest")


def test_the_time_is_ruckig_s():
    ruckig = pytest.importorskip("ruckig")
    rng = np.random.default_rng(2)
    made = random_filter(rng, 500)
    made = tr.JerkFilter(
        made.velocity, made.acceleration, made.jerk, made.velocity_down, made.acceleration_down
    )
    now, target = random_start(rng, made, 500), rng.normal(size=500)
    now = state(now.position, now.velocity, np.where(inside(made, now), now.acceleration, 0.0))
    solver, found = ruckig.Ruckig(1), []
    for i in range(500):
        problem, answer = ruckig.InputParameter(1), ruckig.Trajectory(1)
        problem.current_position = [now.position[i]]
        problem.current_velocity = [now.velocity[i]]
        problem.current_acceleration = [now.acceleration[i]]
        problem.target_position = [target[i]]
        problem.max_velocity = [made.velocity[i]]
        problem.min_velocity = [-made.velocity_down[i]]
        problem.max_acceleration = [made.acceleration[i]]
        problem.min_acceleration = [-made.acceleration_down[i]]
        problem.max_jerk = [made.jerk[i]]
        solver.calculate(problem, answer)
        found.append(answer.duration)
    durations = made.durations(now, target)
    np.testing.assert_allclose(durations, found, rtol=1e-9, atol=1e-9)
    for steps in range(1, 5000):
        now = made.step(now, target, 0.02)
        late, early = steps * 0.02 > durations + 1e-3, steps * 0.02 < durations - 1e-3
        assert rests(now, target)[late].all()
        assert not rests(now, target)[early].any()
        if late.all():
            break


def test_two_half_periods_lead_to_where_one_does():
    rng = np.random.default_rng(3)
    made = random_filter(rng, 2000)
    now, target = random_start(rng, made, 2000, beyond=1.5), rng.normal(size=2000)
    for _ in range(40):
        once = made.step(now, target, 0.1)
        twice = made.step(made.step(now, target, 0.05), target, 0.05)
        np.testing.assert_allclose(once.position, twice.position, atol=1e-9)
        np.testing.assert_allclose(once.velocity, twice.velocity, atol=1e-7)
        now = once


def test_from_rest_no_jerk_limited_move_passes_its_target_or_changes_its_mind():
    rng = np.random.default_rng(4)
    made, target = random_filter(rng, 5000), rng.normal(size=5000)
    now, signs, last = tr.FilterState.at_rest(np.zeros(5000)), np.zeros(5000), np.zeros(5000)
    for _ in range(150):
        now = made.step(now, target, 0.05)
        assert ((target - now.position) * np.sign(target) >= -1e-12).all()
        moving = np.abs(now.acceleration) > 1e-6
        signs += moving & (np.sign(now.acceleration) * last < 0.0)
        last = np.where(moving, np.sign(now.acceleration), last)
    assert signs.max() <= 1


def test_a_mirror_image_moves_as_one():
    rng = np.random.default_rng(5)
    made = random_filter(rng, 500)
    other = tr.JerkFilter(
        made.velocity_down,
        made.acceleration_down,
        made.jerk_down,
        made.velocity,
        made.acceleration,
        made.jerk,
    )
    now, target = random_start(rng, made, 500), rng.normal(size=500)
    mirror = state(-now.position, -now.velocity, -now.acceleration)
    for _ in range(60):
        now, mirror = made.step(now, target, 0.05), other.step(mirror, -target, 0.05)
        np.testing.assert_allclose(mirror.position, -now.position, atol=1e-12)


def test_a_period_that_is_longer_than_the_way_ends_on_the_target():
    now = tr.JerkFilter(1.0, 2.0, 10.0).step(tr.FilterState.at_rest([0.3, -1.0]), [1.0, 2.0], 100.0)
    assert rests(now, [1.0, 2.0]).all()


def test_a_moving_target_is_followed():
    made, now = tr.JerkFilter(2.0, 8.0, 100.0), tr.FilterState.at_rest([0.0])
    misses = []
    for k in range(2000):
        target = np.array([np.sin(0.002 * k)])
        now = made.step(now, target, 0.002)
        misses.append(abs(now.position[0] - target[0]))
    assert max(misses) < 0.3
    assert max(misses[1500:]) < 0.3


def test_from_any_state_a_moving_target_is_followed_inside_the_limits_and_reached_where_it_stops():
    rng, count, period = np.random.default_rng(9), 2000, 0.05
    made = random_filter(rng, count)
    now = random_start(rng, made, count, beyond=10.0)
    pace, size = rng.uniform(0.0, 3.0, count), 10.0 ** rng.uniform(-3.0, 1.0, count)
    for k in range(80):
        target = size * np.sin(pace * k * period)
        before, now = now, made.step(now, target, period)
        assert keeps_its_jerk(made, before, now, period)
        assert inside(made, now)[inside(made, before)].all()
        least, most = (
            pick([limit, before.velocity, released(made, before)], axis=0)
            for pick, limit in ((np.min, -made.velocity_down), (np.max, made.velocity))
        )  # of velocities that no filter could avoid
        assert (now.velocity <= most + 1e-9).all() and (now.velocity >= least - 1e-9).all()
    durations = made.durations(now, target)
    assert rests(made.step(now, target, durations.max() + 1e-3), target).all()
    soon = made.step(now, target, 0.99 * durations[durations > 0.0].min())
    assert not rests(soon, target)[durations > 0.0].any()


def test_dimensions_that_go_together_arrive_together_when_the_slowest_can():
    rng = np.random.default_rng(6)
    for _ in range(60):
        made, period = random_filter(rng, 7), 0.05
        now, target = random_start(rng, made, 7), rng.normal(size=7)
        kept = inside(made, now)
        now = state(now.position, now.velocity, np.where(kept, now.acceleration, 0.0))
        slowest = made.durations(now, target).max()
        step = 0
        while not rests(now, target).any():
            step += 1
            before, now = now, made.step_together(now, target, period)
            assert inside(made, now)[kept].all()
            assert keeps_its_jerk(made, before, now, period)
        assert rests(now, target).all()
        assert slowest / period - 0.1 <= step <= slowest / period + 1.1


def test_targets_changed_in_flight_are_reached_together_too():
    rng = np.random.default_rng(7)
    made, now = random_filter(rng, 6), tr.FilterState.at_rest(np.zeros(6))
    for _ in range(20):
        target = rng.normal(size=6)
        for _ in range(15):
            now = made.step_together(now, target, 0.02)
            assert inside(made, now).all()
    for _ in range(2000):
        now = made.step_together(now, target, 0.02)
        if rests(now, target).any():
            break
    assert rests(now, target).all()


def test_a_straight_way_is_straight_and_keeps_every_dimension_s_limits():
    rng = np.random.default_rng(8)
    for _ in range(20):
        made, period = random_filter(rng, 5), 0.02
        straight, start, target = tr.StraightFilter(made), rng.normal(size=5), rng.normal(size=5)
        unit = (target - start) / np.linalg.norm(target - start)
        now = tr.FilterState.at_rest(start)
        for _ in range(2000):
            before, now = now, straight.step(now, target, period)
            way = now.position - start
            assert np.abs(way - (way @ unit) * unit).max() < 1e-12
            assert inside(made, now).all()
            assert keeps_its_jerk(made, before, now, period)
            if rests(now, target).all():
                break
        assert rests(now, target).all()
    still = straight.step(now, target, period)
    assert rests(still, target).all()


def test_a_straight_way_bends_only_where_it_rests():
    straight = tr.StraightFilter(tr.JerkFilter([1.0, 2.0], 4.0, 40.0))
    now, period, way, bends = tr.FilterState.at_rest([0.0, 0.0]), 0.01, None, 0
    targets = [[1.0, 1.0]] * 40 + [[2.0, 2.0]] * 40 + [[-1.0, -1.0]] * 60 + [[0.0, 3.0]] * 600
    for target in targets:
        before, now = now, straight.step(now, target, period)
        if now.velocity.any():
            unit = now.velocity / np.linalg.norm(now.velocity)
            if way is not None and abs(unit @ way) < 1.0 - 1e-9:
                bends += 1
                assert not before.velocity.any()
            way = unit
    assert bends == 1
    assert rests(now, [0.0, 3.0]).all()


def test_limits_lowered_in_flight_are_come_back_to():
    fast, slow = tr.JerkFilter(2.0, 8.0, 80.0), tr.JerkFilter([0.5, 0.25], 8.0, 80.0)
    steps = ((fast.step, slow.step), (tr.StraightFilter(fast).step, tr.StraightFilter(slow).step))
    for before, after in steps:
        now = tr.FilterState.at_rest([0.0, 0.0])
        for _ in range(40):
            now = before(now, [3.0, 3.0], 0.01)
        assert now.velocity.max() > 1.0
        for _ in range(60):
            now = after(now, [3.0, 3.0], 0.01)
        assert (now.velocity <= np.array([0.5, 0.25]) + 1e-12).all()
        for _ in range(1200):
            now = after(now, [3.0, 3.0], 0.01)
        assert rests(now, [3.0, 3.0]).all()


def follows(now, target, speed):
    return (now.position == target) & (now.velocity == speed) & (now.acceleration == 0.0)


@pytest.mark.parametrize("way", ["step", "step_together"])
def test_a_target_at_constant_velocity_is_caught_inside_the_limits_and_followed(way):
    rng, count, period = np.random.default_rng(12), 300, 0.02
    made = random_filter(rng, count)
    now = random_start(rng, made, count, beyond=1.0)
    speed = rng.uniform(-0.95 * made.velocity_down, 0.95 * made.velocity)
    first = rng.normal(size=count)
    times = made.durations(now, first, velocity=speed)
    for k in range(1, 300):
        target = first + k * period * speed
        before, now = now, getattr(made, way)(now, target, period, velocity=speed)
        assert keeps_its_jerk(made, before, now, period)
        assert inside(made, now)[inside(made, before)].all()
        caught = times <= k * period if way == "step" else times.max() <= k * period
        assert (
            np.abs(now.position - target)[np.broadcast_to(caught, (count,))].max(initial=0) < 1e-9
        )
    assert (times < 6.0).sum() > count // 2


def test_the_time_to_a_moving_target_is_that_of_its_frame():
    """A double-s motion in the frame of the target is the truth."""
    made = tr.JerkFilter(1.0, 4.0, 40.0)
    truth = tr.double_s(
        [-0.5], [0.0], velocity=1.3, acceleration=4.0, jerk=40.0, start_velocity=[0.3]
    )
    now = unaccelerated([-0.5], [0.0])
    assert made.durations(now, [0.0], velocity=-0.3)[0] == pytest.approx(truth.domain[1], rel=1e-9)


def test_targets_faster_than_the_limits_are_chased_at_them():
    made, now = tr.JerkFilter(1.0, 4.0, 40.0), tr.FilterState.at_rest([0.0])
    for k in range(1, 400):
        now = made.step(now, [0.5 + 0.02 * k], 0.01, velocity=[2.0])
        assert now.velocity[0] <= 1.0 + 1e-12
    assert now.velocity[0] == pytest.approx(1.0, abs=1e-6)


def test_a_straight_filter_rides_with_a_target_that_turns_and_with_limits_that_change():
    fast, slow = (tr.StraightFilter(tr.JerkFilter([v, v], 4.0, 40.0)) for v in (1.0, 0.6))
    now, period, part = tr.FilterState.at_rest([0.0, 0.0]), 0.01, np.array([0.4, -0.2])
    for speed, made in (([0.3, 0.0], fast), ([0.3, 0.0], slow), ([0.0, -0.25], slow), (0.0, fast)):
        rate = np.broadcast_to(speed, 2)
        for _ in range(300):
            part = part + period * rate
            before, now = now, made.step(now, part, period, velocity=speed)
            assert keeps_its_jerk(made.limits, before, now, period)
            assert inside(made.limits, now)[inside(made.limits, before)].all()
        assert follows(now, part, rate).all()


def test_a_straight_way_to_a_moving_target_is_straight_in_its_frame():
    made, period, rate = (
        tr.StraightFilter(tr.JerkFilter(1.0, 4.0, 40.0)),
        0.01,
        np.array([0.3, 0.1]),
    )
    now, part, ways = tr.FilterState.at_rest([0.0, 0.0]), np.array([0.1, 0.5]), []
    for _ in range(400):
        part = part + period * rate
        now = made.step(now, part, period, velocity=rate)
        ways.append((now.position - part, now.velocity - rate))
    gaps, slips = np.array([each for each in ways if np.linalg.norm(each[1]) > 1e-9]).swapaxes(0, 1)
    directions = slips / np.linalg.norm(slips, axis=1, keepdims=True)
    turns = np.linalg.norm(np.diff(directions, axis=0), axis=1) > 1e-6
    assert turns.sum() == 1  # takes on the velocity, then comes straight
    last = slice(np.flatnonzero(turns)[0] + 1, None)
    assert np.abs(np.linalg.det(np.stack([gaps, directions], axis=1)[last])).max() < 1e-9
    assert follows(now, part, rate).all()


def test_a_state_copies_what_it_is_given_and_is_read_only():
    """Lists are taken; the positions that filters return cannot be changed either."""
    own = np.array([1.0])
    state = tr.FilterState(own, [0.0], [0.0])
    own[0] = np.nan
    moved = tr.JerkFilter(1.0, 1.0, 1.0).step(state, [2.0], 0.1)
    on_line = tr.StraightFilter(tr.JerkFilter(1.0, 1.0, 1.0)).step(state, [2.0], 0.1)
    for each in (state, moved, on_line):
        assert np.isfinite(each.position).all()
        with pytest.raises(ValueError, match="read-only"):
            each.position[0] = 3.0
