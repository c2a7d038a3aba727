from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import timing
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import InvalidInput, LimitsInfeasible

LIMITS = JointLimits(
    joint_names=("elbow", "wrist"),
    lower=(-2.0, -np.inf),
    upper=(2.0, np.inf),
    velocity=(1.0, 4.0),
    acceleration=(5.0, 20.0),
    jerk=(50.0, 200.0),
)


def between(first, last, duration, samples=200, start=0.0):
    """From one configuration to another with smooth starts and stops, Flash and Hogan 1985."""
    u = np.linspace(0, 1, samples)
    s = minimum_jerk(u)
    q = np.asarray(first) + np.outer(s, np.subtract(last, first))
    return lt.JointTrajectory(start + duration * u, q, joint_names=LIMITS.joint_names)


def ratios(report):
    return np.array([p.ratio for p in (report.velocity, report.acceleration, report.jerk)])


def test_the_peaks_are_those_of_the_motion():
    """A minimum-jerk motion over 1 peaks at 15/8 T, 10/sqrt(3) T^2 and 60 T^3."""
    duration = 2.0
    report = timing.check_limits(between([0, 0], [1, 0], duration, 2000), LIMITS)
    expected = [15 / 8 / duration, 10 / np.sqrt(3) / duration**2 / 5, 60 / duration**3 / 50]
    np.testing.assert_allclose(ratios(report), expected, rtol=5e-3)
    assert report.velocity.joint == "elbow"
    assert report.velocity.time == pytest.approx(duration / 2, abs=1e-2)
    assert report.position.ratio == 0.5
    assert report.position.time == duration
    assert np.array_equal(report.velocity.ratios[1:], [0])
    assert report.ok
    assert report.unchecked == ()


@given(st.floats(0.5, 20), st.integers(2, 300), st.floats(-3, 3, allow_subnormal=False))
def test_samples_of_a_motion_inside_its_limits_are_never_judged_outside(duration, samples, target):
    peak = abs(target) * np.array([15 / 8 / duration, 10 / 3**0.5 / duration**2, 60 / duration**3])
    motion = between([0, 0], [0, target], duration, samples)
    assert (ratios(timing.check_limits(motion, LIMITS)) <= peak / [4, 20, 200] * (1 + 1e-9)).all()


def test_a_violation_is_reported_not_raised():
    report = timing.check_limits(between([0, 0], [2.5, 0], 0.5), LIMITS)
    assert not report.ok
    assert not report.position.ok
    assert not report.jerk.ok
    assert report.position.ratio == 1.25
    assert report.position.joint == "elbow"


def test_an_end_at_full_speed_costs_acceleration_and_jerk():
    times = np.linspace(0, 1, 101)
    ramp = lt.JointTrajectory(times, np.column_stack([times, times]))
    report = timing.check_limits(ramp, LIMITS)
    assert report.velocity.ratio == pytest.approx(1.0)
    assert report.acceleration.ratio == pytest.approx(1.0 / 0.01 / 5)
    assert report.jerk.ratio > 10
    assert report.acceleration.time in (0.0, 1.0)


def test_the_trajectorys_own_derivatives_count():
    still = between([0, 0], [0, 0], 1.0, 3)
    for name in ("velocities", "accelerations"):
        values = np.zeros((3, 2))
        values[1, 1] = -30.0
        report = timing.check_limits(replace(still, **{name: values}), LIMITS)
        assert not report.ok
        peak = report.velocity if name == "velocities" else report.acceleration
        assert (peak.joint, peak.time) == ("wrist", 0.5)


def test_what_has_no_limits_is_said_to_be_unchecked():
    limits = replace(LIMITS, acceleration=None, jerk=None)
    report = timing.check_limits(between([0, 0], [1, 0], 2.0), limits)
    assert report.ok
    assert report.acceleration is None
    assert report.unchecked == ("acceleration", "jerk")
    scaled = timing.scale_to_limits(between([0, 0], [1, 0], 0.01), limits)
    assert timing.check_limits(scaled, limits).velocity.ratio == pytest.approx(1.0)


def test_a_motion_inside_its_limits_is_left_alone():
    slow = between([0, 0], [1, 0], 10.0, start=3.0)
    assert timing.scale_to_limits(slow, LIMITS) is slow


@pytest.mark.parametrize(
    ("limits", "order"),
    [
        (replace(LIMITS, acceleration=None, jerk=None), 1),
        (replace(LIMITS, jerk=None, velocity=(9e9, 9e9)), 2),
        (replace(LIMITS, velocity=(9e9, 9e9), acceleration=(9e9, 9e9)), 3),
    ],
)
def test_each_derivative_asks_for_its_own_root(limits, order):
    fast = between([0, 0], [1, 0], 0.1)
    worst = ratios_known(timing.check_limits(fast, limits))
    scaled = timing.scale_to_limits(fast, limits)
    assert scaled.duration == pytest.approx(fast.duration * worst ** (1 / order))


def ratios_known(report):
    peaks = (report.velocity, report.acceleration, report.jerk)
    return max(peak.ratio for peak in peaks if peak is not None)


def test_path_start_and_names_stay_and_derivatives_scale_along():
    fast = timing.differentiate(between([0, 1], [1, -1], 0.1, start=7.0))
    scaled = timing.scale_to_limits(fast, LIMITS)
    factor = scaled.duration / fast.duration
    assert factor > 1
    assert scaled.times[0] == 7.0
    assert np.array_equal(scaled.positions, fast.positions)
    assert scaled.joint_names == fast.joint_names
    np.testing.assert_allclose(scaled.velocities, fast.velocities / factor)
    np.testing.assert_allclose(scaled.accelerations, fast.accelerations / factor**2)


steps = st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=12)


@given(steps, arrays(float, (13, 2), elements=st.floats(-2, 2)), st.floats(-1e4, 1e4))
def test_scaling_never_exceeds_a_limit_and_never_speeds_up(dts, positions, start):
    times = start + np.cumsum([0.0, *dts])
    assume((np.diff(times) > 0).all())
    motion = lt.JointTrajectory(times, positions[: len(times)])
    for trajectory in (motion, timing.differentiate(motion)):
        scaled = timing.scale_to_limits(trajectory, LIMITS)
        report = timing.check_limits(scaled, LIMITS)
        assert (ratios(report) <= 1.0).all()
        assert scaled.duration >= trajectory.duration
        # No slower than needed: it was inside already, or one limit is reached.
        assert scaled is trajectory or ratios(report).max() > 1 - 1e-6


def test_positions_outside_their_limits_name_the_joint():
    with pytest.raises(LimitsInfeasible, match="elbow leaves its position limits at") as caught:
        timing.scale_to_limits(between([0, 0], [2.5, 0], 5.0), LIMITS)
    assert caught.value.joint == "elbow"


def test_a_joint_that_must_not_move_is_infeasible_only_if_it_moves():
    locked = replace(LIMITS, velocity=(1.0, 0.0))
    with pytest.raises(LimitsInfeasible) as caught:
        timing.scale_to_limits(between([0, 0], [1, 1], 5.0), locked)
    assert caught.value.joint == "wrist"
    assert timing.check_limits(between([0, 0], [1, 0], 5.0), locked).ok


@pytest.mark.parametrize(
    ("bounds", "q", "ok"),
    [
        ((-1, 1), 1.0, True),
        ((-1, 1), 1.001, False),
        ((0, 0), 0.0, True),
        ((0, 0), 0.1, False),
        ((-np.inf, 1), -1e6, True),
        ((-np.inf, 1), 2.0, False),
        ((-np.inf, np.inf), 1e9, True),
    ],
)
def test_position_limits_may_be_open_or_closed(bounds, q, ok):
    limits = replace(LIMITS, lower=(bounds[0], -9), upper=(bounds[1], 9))
    report = timing.check_limits(lt.JointTrajectory([0.0], [[q, 0.0]]), limits)
    assert report.position.ok == ok
    assert report.ok == ok


def test_one_sample_stands_still():
    single = lt.JointTrajectory([1.0], [[0.0, 1.0]])
    assert timing.scale_to_limits(single, LIMITS) is single
    assert np.array_equal(timing.differentiate(single).velocities, [[0, 0]])


def test_derivatives_are_those_of_the_motion_and_rest_at_the_ends():
    trajectory = timing.differentiate(between([0, 0], [1, 0], 2.0, 400, start=5.0))
    u = np.linspace(0, 1, 400)
    velocities = (30 * u**2 - 60 * u**3 + 30 * u**4) / 2.0
    accelerations = (60 * u - 180 * u**2 + 120 * u**3) / 4.0
    np.testing.assert_allclose(trajectory.velocities[:, 0], velocities, atol=1e-6)
    np.testing.assert_allclose(trajectory.accelerations[:, 0], accelerations, atol=1e-3)
    assert np.array_equal(trajectory.velocities[[0, -1]], np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        (JointLimits(("elbow",), [-1], [1], [1]), "limits: expected limits of 2 joints, got 1"),
        (replace(LIMITS, joint_names=("wrist", "elbow")), r"limits: expected limits of \['elbow'"),
        (None, "limits: expected JointLimits, got NoneType"),
    ],
)
def test_limits_that_do_not_fit_are_refused(limits, message):
    for call in (timing.check_limits, timing.scale_to_limits):
        with pytest.raises(InvalidInput, match=message):
            call(between([0, 0], [1, 1], 1.0), limits)


def test_what_is_no_joint_trajectory_is_refused():
    points = lt.Trajectory([0, 1], [[0.0, 0], [1, 1]])
    for call in (
        lambda: timing.check_limits(points, LIMITS),
        lambda: timing.scale_to_limits(None, LIMITS),
        lambda: timing.differentiate(points),
    ):
        with pytest.raises(InvalidInput, match="trajectory: expected a JointTrajectory"):
            call()
