"""One verdict on limits: the quintics between samples, whatever arrays a motion carries."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from motions import minimum_jerk, with_derivatives
from refusals import refused
from scipy.interpolate import BPoly, CubicSpline

import leadthrough as lt
from leadthrough import timing
from leadthrough.arm import JointLimits
from leadthrough.errors import InvalidInput

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
    q = np.asarray(first) + np.outer(minimum_jerk(u), np.subtract(last, first))
    return lt.JointTrajectory(start + duration * u, q, joint_names=LIMITS.joint_names)


def ratios(report):
    peaks = (report.velocity, report.acceleration, report.jerk)
    return np.array([peak.ratio for peak in peaks if peak is not None])


def curve(motion):
    """The quintic Hermite curve of SciPy."""
    states = [motion.positions, motion.velocities, motion.accelerations]
    return BPoly.from_derivatives(motion.times, np.stack(states, axis=1))


def roots_inside(polynomial):
    inside = [root.real for root in polynomial.roots() if abs(root.imag) < 1e-9]
    return [root for root in inside if 0.0 < root < 1.0]


def exact_peaks(motion):
    """Largest magnitudes of position, velocity and acceleration of each joint, by roots."""
    peaks = np.zeros((3, motion.positions.shape[1]))
    for j in range(motion.positions.shape[1]):
        for k, width in enumerate(np.diff(motion.times)):
            steps = np.array([[1.0, width, width**2]] * 2)
            states = np.array(
                [
                    [motion.positions[i, j], motion.velocities[i, j], motion.accelerations[i, j]]
                    for i in (k, k + 1)
                ]
            )
            rows = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]]
            rows += [[1] * 6, [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]]
            position = np.polynomial.Polynomial(np.linalg.solve(rows, (states * steps).ravel()))
            for order in range(3):
                values = position.deriv(order) if order else position
                at = np.array([0.0, 1.0, *roots_inside(values.deriv())])
                peak = np.abs(values(at)).max() / width**order
                peaks[order, j] = max(peaks[order, j], peak)
    return peaks


numbers = st.floats(-2.0, 2.0, allow_subnormal=False)
steps = st.lists(st.floats(0.05, 1.0), min_size=1, max_size=4)


@given(steps, arrays(float, (3, 5, 2), elements=numbers))
def test_the_peaks_are_those_of_the_polynomials_and_of_dense_samples(widths, states):
    times = np.cumsum([0.0, *widths])
    still = np.zeros((1, 2))
    rows = [np.round(part[: len(times)], 6) for part in states]
    motion = lt.JointTrajectory(times, *rows)
    free = replace(LIMITS, lower=np.full(2, -np.inf), upper=np.full(2, np.inf))
    report = timing.check_limits(motion, free)
    pad = min(widths[0], 1.0), min(widths[-1], 1.0)
    whole = lt.JointTrajectory(
        [times[0] - pad[0], *times, times[-1] + pad[1]],
        np.vstack([rows[0][:1], rows[0], rows[0][-1:]]),
        *(np.vstack([still, part, still]) for part in rows[1:]),
    )
    _, speeds, pushes = exact_peaks(whole)
    np.testing.assert_allclose(report.velocity.ratios, speeds / LIMITS.velocity, atol=1e-7)
    np.testing.assert_allclose(report.acceleration.ratios, pushes / LIMITS.acceleration, atol=1e-6)
    jerks = np.abs(np.diff(whole.accelerations, axis=0)) / np.diff(whole.times)[:, None]
    np.testing.assert_allclose(report.jerk.ratios, jerks.max(axis=0) / LIMITS.jerk, atol=1e-9)
    at = np.linspace(*whole.times[[0, -1]], 500)
    for order, peaks, limit in (
        (1, report.velocity, LIMITS.velocity),
        (2, report.acceleration, LIMITS.acceleration),
    ):
        dense = np.abs(curve(whole)(at, order)).max(axis=0) / limit
        assert (dense <= peaks.ratios * (1.0 + 1e-9) + 1e-9).all()


def test_positions_between_samples_count():
    bow = lt.JointTrajectory(
        [0.0, 1.0], np.zeros((2, 2)), [[4.0, 0.0], [-4.0, 0.0]], np.zeros((2, 2))
    )
    report = timing.check_limits(bow, LIMITS)
    assert exact_peaks(bow)[0, 0] == pytest.approx(1.25)
    assert report.position.ratio == pytest.approx(0.625)
    assert report.position.time == pytest.approx(0.5)


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


@given(st.floats(0.5, 20), st.integers(12, 300), st.floats(-3, 3, allow_subnormal=False))
def test_samples_of_a_smooth_motion_are_judged_as_the_motion(duration, samples, target):
    peak = abs(target) * np.array([15 / 8 / duration, 10 / 3**0.5 / duration**2, 60 / duration**3])
    used = ratios(timing.check_limits(between([0, 0], [0, target], duration, samples), LIMITS))
    assert (used <= peak / [4, 20, 200] * (1.0 + 5.0 / samples)).all()


def test_a_violation_is_reported_not_raised():
    report = timing.check_limits(between([0, 0], [2.5, 0], 0.5), LIMITS)
    assert not report.ok
    assert not report.position.ok
    assert not report.jerk.ok
    assert report.position.ratio == 1.25
    assert report.position.joint == "elbow"


def test_an_end_at_full_speed_costs_acceleration_and_jerk():
    times = np.linspace(0, 1, 101)
    both = np.column_stack([times, times])
    ramp = lt.JointTrajectory(times, both, np.ones((101, 2)), np.zeros((101, 2)))
    report = timing.check_limits(ramp, LIMITS)
    assert report.acceleration.ratio > 1.0 / 0.01 / 5
    assert 0.0 <= report.acceleration.time <= 1.0
    from_rest = timing.check_limits(lt.JointTrajectory(times, both), LIMITS)
    assert from_rest.acceleration.ratio > 1.0 / 0.01 / 5
    assert from_rest.jerk.ratio > 10
    inside = lt.JointTrajectory(times[[0, -1]], both[[0, -1]], np.zeros((2, 2)), np.zeros((2, 2)))
    assert timing.check_limits(inside, LIMITS).velocity.ratio == pytest.approx(1.875)


def test_the_trajectorys_own_derivatives_count():
    still = between([0, 0], [0, 0], 1.0, 3)
    for name in ("velocities", "accelerations"):
        values = np.zeros((3, 2))
        values[1, 1] = -30.0
        report = timing.check_limits(replace(still, **{name: values}), LIMITS)
        assert not report.ok
        peak = report.velocity if name == "velocities" else report.acceleration
        assert peak.joint == "wrist"
        assert peak.ratio >= 30.0 / (4.0 if name == "velocities" else 20.0)


def test_quantities_without_limits_are_reported_as_unchecked():
    limits = replace(LIMITS, acceleration=None, jerk=None)
    report = timing.check_limits(between([0, 0], [1, 0], 2.0), limits)
    assert report.ok
    assert report.acceleration is None
    assert report.unchecked == ("acceleration", "jerk")
    assert all(
        each.kind == "velocity"
        for each in timing.binding_limits(between([0, 0], [1, 0], 2.0), limits)
    )


def test_a_joint_that_must_not_move_is_judged_only_if_it_moves():
    locked = replace(LIMITS, velocity=(1.0, 0.0))
    assert not timing.check_limits(between([0, 0], [1, 1], 5.0), locked).ok
    assert timing.check_limits(between([0, 0], [1, 0], 5.0), locked).ok
    nearly = between([0, 0], [1, 1e-16], 5.0)  # as a time law rounds it
    assert timing.check_limits(nearly, locked).ok
    assert all(each.joint == "elbow" for each in timing.binding_limits(nearly, locked))


@pytest.mark.parametrize(
    ("bounds", "q", "ok"),
    [
        ((-1, 1), 1.0, True),
        ((-1, 1), 1.001, False),
        ((0, 0), 0.0, True),
        ((0, 0), 0.1, False),
        ((0, 0), 1e-16, True),
        ((-np.inf, 1), 1 + 1e-15, True),
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


def test_missing_arrays_are_slopes_of_splines():
    motion = between([0, 0], [1, -1], 2.0, 30, start=5.0)
    filled = with_derivatives(motion)
    spline = CubicSpline(motion.times, motion.positions, bc_type="clamped")
    np.testing.assert_allclose(filled.velocities, spline(motion.times, 1), atol=1e-12)
    slopes = CubicSpline(motion.times, filled.velocities)(motion.times, 1)
    np.testing.assert_allclose(filled.accelerations, slopes, atol=1e-10)
    assert not filled.velocities[[0, -1]].any()
    assert with_derivatives(filled) is filled
    own = replace(motion, velocities=np.ones((30, 2)))
    assert np.array_equal(with_derivatives(own).velocities, own.velocities)
    np.testing.assert_allclose(with_derivatives(own).accelerations, 0.0, atol=1e-12)
    assert np.array_equal(
        with_derivatives(lt.JointTrajectory([1.0], [[0.0, 1.0]])).velocities, [[0, 0]]
    )


@pytest.mark.parametrize("rate", [100.0, 500.0])
def test_positions_alone_are_judged_straight_at_the_receivers_rate(rate):
    motion = between([0, 0], [1, 0], 2.0, 21)
    report = timing.check_limits(motion, LIMITS, linear_rate=rate)
    clock = np.arange(round(2.0 * rate) + 1) / rate
    q = np.interp(clock, motion.times, motion.positions[:, 0])
    standing = np.concatenate([q[[0] * 2], q, q[[-1] * 2]])
    for order, peak in enumerate((report.velocity, report.acceleration, report.jerk), 1):
        used = np.abs(np.diff(standing, order)).max() * rate**order
        limit = (LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk)[order - 1][0]
        assert peak.ratio == pytest.approx(used / limit, rel=1e-6)
    # Faster receivers see corners at the samples that the quintics do not have.
    assert report.acceleration.ratio > timing.check_limits(motion, LIMITS).acceleration.ratio


def test_wrong_arguments_are_named():
    for motion, limits, argument in [
        (between([0, 0], [1, 1], 1.0), JointLimits(("elbow",), [-1], [1], [1]), "trajectory"),
        (between([0, 0], [1, 1], 1.0), replace(LIMITS, joint_names=("x", "elbow")), "trajectory"),
        (between([0, 0], [1, 1], 1.0), None, "limits"),
        (lt.Trajectory([0, 1], [[0.0, 0], [1, 1]]), LIMITS, "trajectory"),
        (None, LIMITS, "trajectory"),
    ]:
        for call in [timing.check_limits, timing.binding_limits]:
            refused(f"^{argument}: expected", call, motion, limits)
    with pytest.raises(InvalidInput, match="linear_rate"):
        timing.check_limits(between([0, 0], [1, 1], 1.0), LIMITS, linear_rate=0.0)


UR3 = lt.Arm.load("ur3")


def spline():
    way = np.random.default_rng(1).uniform(-0.5, 0.5, (12, 6))
    through = CubicSpline(np.linspace(0.0, 1.0, 12), way)
    return lt.trajectories.Spline(through.x, through.c[::-1].transpose(1, 0, 2))


def followed():
    u = np.linspace(0.0, 1.0, 60)
    angle = 2.0 * np.pi * minimum_jerk(u)
    tip = np.column_stack([0.3 + 0.05 * np.cos(angle), 0.05 * np.sin(angle), np.full(60, 0.2)])
    return UR3.follow(lt.PoseTrajectory(2.0 * u, tip, [(0, 1, 0, 0)] * 60))


WAY = np.random.default_rng(0).uniform(-1.0, 1.0, (6, 6))
PATHS = {
    "spline": (spline, {}),
    "way-points": (lambda: WAY, {"dwell_times": {2: 0.1}}),
    "blended": (lambda: WAY, {"blend": 0.05}),
    "followed": (followed, {}),
}


@pytest.mark.parametrize("rate", [1000.0, 500.0, 125.0])
@pytest.mark.parametrize("path", PATHS)
def test_what_retime_returns_is_inside_the_limits_between_samples_too(path, rate):
    build, options = PATHS[path]
    motion = lt.retime(build(), UR3.limits, rate=rate, **options)
    assert timing.check_limits(motion, UR3.limits).ok
    fine = np.linspace(*motion.times[[0, -1]], 4 * len(motion.times))
    for order, limit in ((1, UR3.limits.velocity), (2, UR3.limits.acceleration)):
        assert (np.abs(curve(motion)(fine, order)) <= limit * (1.0 + 1e-6)).all()
    jerks = np.abs(np.diff(motion.accelerations, axis=0)) * rate
    assert (jerks <= UR3.limits.jerk * (1.0 + 1e-6)).all()


def test_the_law_is_found_along_a_followed_path_faster_than_its_own_pace():
    joints = followed()
    fastest, kept = lt.retime(joints, UR3.limits), lt.keep_timing(joints, UR3.limits)
    assert fastest.duration < 1.01 * joints.duration <= 1.02 * kept.duration
    assert joints.velocities is not None
    assert joints.accelerations is not None
