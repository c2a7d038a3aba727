"""A motion's own timing, kept where the limits allow, and motions at a position limit."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import trajectories as tr
from leadthrough.errors import InvalidInput, LimitsInfeasible
from leadthrough.timing import check_limits

PANDA = lt.Arm.load("panda").limits
UR3 = lt.Arm.load("ur3").limits
MIDDLE = 0.5 * (PANDA.lower + PANDA.upper)


def test_a_trajectory_keeps_its_timing_wherever_the_limits_allow():
    times = np.linspace(2.0, 8.0, 121)
    swing = tr.minimum_jerk_time_scaling((times - 2.0) / 6.0)
    shown = lt.JointTrajectory(times, MIDDLE + np.outer(swing, np.linspace(-0.5, 0.5, 7)))
    kept = lt.keep_timing(shown, PANDA)
    fastest = lt.retime(shown, PANDA)
    assert fastest.duration < 0.3 * shown.duration
    assert kept.times[0] == 2.0
    assert kept.duration == pytest.approx(shown.duration, rel=0.01)
    middle = np.interp(5.0, kept.times, kept.positions[:, 0])
    assert middle == pytest.approx(np.interp(5.0, times, shown.positions[:, 0]), abs=0.01)


def test_a_curve_reaches_no_knot_before_its_time():
    points = MIDDLE + np.random.default_rng(8).uniform(-0.2, 0.2, (6, 7))
    curve = tr.BSpline(points, [0, 0, 0, 0, 3, 4, 8, 8, 8, 8], 3)
    kept = lt.keep_timing(curve, PANDA)
    assert kept.duration == pytest.approx(8.0, rel=0.01)
    knot = curve.evaluate(3.0)
    reached = kept.times[np.abs(kept.positions - knot).max(axis=1).argmin()]
    assert reached == pytest.approx(3.0, abs=0.1)


def test_pauses_keep_their_time_and_their_events():
    """Three rests of 3 s, before, between and after two reaches of 2 s, and nothing but a rest."""
    rise = tr.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 501))
    share = np.concatenate([np.zeros(750), rise, np.ones(750), 1.0 + rise, np.full(750, 2.0)])
    times = 0.004 * np.arange(len(share))
    events = [lt.Event(times[row], "wait") for row in (200, 1600, 3200)]
    noise = np.random.default_rng(1).normal(0.0, 1e-6, (len(share), 7))
    for still in (share, np.zeros_like(share)):
        way = MIDDLE + 0.1 * still[:, None]
        shown = lt.JointTrajectory(times, way, events=events)
        kept = lt.keep_timing(shown, PANDA)
        assert kept.duration == pytest.approx(shown.duration, abs=0.1)
        assert [each.time for each in kept.events] == pytest.approx([0.8, 6.4, 12.8], abs=0.1)
        late = np.interp(times, kept.times, kept.positions[:, 0]) - way[:, 0]
        assert np.abs(late).max() < 0.003
    kept = lt.keep_timing(lt.JointTrajectory(times, MIDDLE + 0.1 * share[:, None] + noise), PANDA)
    crossed = [np.interp(MIDDLE[0] + at, kept.positions[:, 0], kept.times) for at in (0.01, 0.11)]
    assert min(np.subtract(crossed, np.interp([0.1, 1.1], share, times))) > -1e-3


def test_times_that_are_not_in_seconds_are_refused_instead_of_filling_the_memory():
    far = lt.JointTrajectory([0.0, 1e12], np.stack([MIDDLE, MIDDLE]))
    for call in (
        lambda: check_limits(far, PANDA, linear_rate=125.0),
        lambda: lt.keep_timing(far, PANDA),
        lambda: lt.retime(np.stack([MIDDLE, MIDDLE + 0.1]), PANDA, dwell_times={0: 1e12}),
    ):
        with pytest.raises(InvalidInput, match=r"rate: .* samples; .* times are in s"):
            call()


def hasty():
    """Six seconds with two stretches that are shown much faster than the arm can pass them."""
    share = np.linspace(0.0, 1.0, 601)
    pace = 0.15 * np.sin(np.pi * share) ** 2
    for middle, width, size in ((0.3, 0.03, 3.0), (0.65, 0.02, 2.0)):
        pace += size * np.exp(-(((share - middle) / width) ** 2))
    way = np.cumsum(pace)
    way = (way - way[0]) / (way[-1] - way[0])
    q = MIDDLE + 0.5 * np.sin(3.0 * np.outer(way, 1.0 + 0.1 * np.arange(7)) + np.arange(7))
    return lt.JointTrajectory(6.0 * share, q)


def lateness(shown, motion, rows=slice(20, -20)):
    """By how much the motion is late where the samples were shown, but for the ends, at rest."""
    along = [
        np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(each.positions, axis=0), axis=1))])
        for each in (shown, motion)
    ]
    reached = np.interp(along[0] * along[1][-1] / along[0][-1], along[1], motion.times)
    return (reached - shown.times)[rows]


@pytest.mark.parametrize("share", [1.0, 0.05])
def test_after_a_stretch_that_was_too_fast_the_motion_catches_up_and_comes_never_early(share):
    shown, limits = hasty(), replace(PANDA, jerk=share * PANDA.jerk)
    motion = lt.keep_timing(shown, limits)
    assert check_limits(motion, limits).ok
    late = lateness(shown, motion)
    assert late.min() > -1e-3
    assert late.max() > 0.06  # on the stretches that are too fast
    assert np.abs(late[230:330]).max() < 2e-3  # on time again between the two stretches
    assert abs(late[450:].max()) < 0.03
    assert motion.duration < 6.0 + 0.06


@pytest.mark.parametrize("seed", [1, 5, 9, 13])
def test_nothing_is_reached_early_after_a_slow_beginning(seed):
    """Some of the recording's slowest parts are shorter than a step of the law's grid."""
    rng = np.random.default_rng(seed)
    share = np.linspace(0.0, 1.0, int(rng.integers(800, 1500)))
    duration = rng.uniform(6.0, 12.0)
    pace = 0.15 * np.sin(np.pi * share) ** 2
    for middle, size in zip(rng.uniform(0.15, 0.7, 2), rng.uniform(1.0, 3.0, 2), strict=True):
        pace += size * np.exp(-(((share - middle) / 0.03) ** 2)) * 6.0 / duration
    way = np.cumsum(pace)
    q = MIDDLE + 0.5 * np.sin(3.0 * np.outer(way / way[-1], 1.0 + 0.1 * np.arange(7)))
    shown = lt.JointTrajectory(duration * share, q)
    motion = lt.keep_timing(shown, PANDA)
    rows = slice(len(share) // 30, -len(share) // 30)
    assert lateness(shown, motion, rows).min() > -2e-3
    assert check_limits(motion, PANDA).ok


def hurried(seed):
    """A recording at rest at its ends, with three stretches that may be too fast, and limits."""
    rng = np.random.default_rng(seed)
    limits = replace(UR3, jerk=UR3.jerk * [1.0, 0.3, 0.1][seed % 3])
    duration, count = rng.uniform(4.0, 12.0), int(rng.integers(300, 1500))
    share = np.linspace(0.0, 1.0, count)
    pace = 0.15 * np.sin(np.pi * share) ** 2
    places = (rng.uniform(low, high, 3) for low, high in ((0.1, 0.9), (0.015, 0.06), (0.0, 3.0)))
    for middle, width, size in zip(*places, strict=True):
        pace += size * np.exp(-(((share - middle) / width) ** 2)) * 6.0 / duration
    way = np.cumsum(pace)
    way = (way - way[0]) / (way[-1] - way[0])
    bend = rng.uniform(2.0, 6.0) * np.outer(way, 1.0 + 0.1 * rng.permutation(6))
    return lt.JointTrajectory(
        duration * share, 0.5 * np.sin(bend + rng.uniform(0.0, 6.0, 6))
    ), limits


@pytest.mark.parametrize("seed", [59, 65, 95])
def test_catching_up_brings_nothing_early_before_or_after(seed):
    """A pace freed at one point was kept up before it too, by up to 5 ms."""
    shown, limits = hurried(seed)
    rows = slice(len(shown) // 30, -len(shown) // 30)
    assert lateness(shown, lt.keep_timing(shown, limits), rows).min() > -1e-3


def test_where_a_later_point_limits_the_pace_the_motion_catches_up_behind_it():
    """All attempts were made before that point, and half of the motion was 0.3 s late."""
    shown, limits = hurried(107)
    late = lateness(shown, lt.keep_timing(shown, limits))
    assert late[int(0.9 * len(late))] < 0.03


def test_a_stop_that_was_not_shown_is_made_up_for():
    shown, limits = hasty(), PANDA
    motion = lt.keep_timing(shown, limits, dwell_times={250: 0.5})
    late = lateness(shown, motion)
    assert late[240:260].max() > 0.4
    assert late[470:].max() < 0.03
    assert late.min() > -1e-3
    assert check_limits(motion, limits).ok


def test_a_motion_too_fast_everywhere_is_slowed_down_and_keeps_the_verdict():
    shown = replace(hasty(), times=0.5 * hasty().times)
    motion = lt.keep_timing(shown, PANDA, rate=250.0)
    assert motion.duration > shown.duration
    assert check_limits(motion, PANDA).ok


@pytest.mark.parametrize(
    ("change", "argument"),
    [
        ({"motion": [[0.0] * 7, [1.0] * 7]}, "motion"),
        ({"limits": None}, "limits"),
        ({"rate": 0.0}, "rate"),
        ({"path_tolerance": -1.0}, "path_tolerance"),
        ({"dwell_times": {900: 1.0}}, "dwell_times"),
        ({"tip_speed": 0.1}, "tip_speed"),
        ({"inverse_dynamics": 3}, "inverse_dynamics"),
    ],
)
def test_wrong_arguments_are_named(change, argument):
    arguments = {"motion": hasty(), "limits": PANDA, **change}
    with pytest.raises(InvalidInput, match=f"^{argument}: expected"):
        lt.keep_timing(arguments.pop("motion"), arguments.pop("limits"), **arguments)


def swing(beyond, samples=101):
    """Out to the first joint's upper limit, and by a fraction beyond, and back."""
    times = np.linspace(0.0, 2.0, samples)
    u = tr.minimum_jerk_time_scaling(0.5 * times)
    q = MIDDLE + 0.3 * np.outer(u, np.ones(7))
    q[:, 0] = MIDDLE[0] + (1.0 + beyond) * (PANDA.upper[0] - MIDDLE[0]) * np.sin(np.pi * u)
    return times, q


@pytest.mark.parametrize("path_tolerance", [1e-6, 1e-5, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("samples", [100, 101])  # with one at the top and without
def test_a_motion_that_touches_its_limit_keeps_it_and_its_samples(samples, path_tolerance):
    times, q = swing(0.0, samples)
    motion = lt.retime(lt.JointTrajectory(times, q), PANDA, path_tolerance=path_tolerance)
    assert (motion.positions <= PANDA.upper + 1e-9).all()
    for sample in q[::10]:
        # Between two samples of the motion, at 1 kHz, the arm moves by less than 6e-3.
        assert np.abs(motion.positions - sample).max(axis=1).min() < path_tolerance + 3e-3
    top = MIDDLE[0] + (PANDA.upper[0] - MIDDLE[0]) * (1.0 - 2e-4)
    assert motion.positions[:, 0].max() > min(top, PANDA.upper[0] - 2.0 * path_tolerance)


def test_samples_held_at_the_limit_stay_there():
    times, q = swing(0.05)
    held = np.minimum(q, PANDA.upper)
    motion = lt.retime(lt.JointTrajectory(times, held), PANDA, path_tolerance=1e-3)
    assert (motion.positions <= PANDA.upper + 1e-9).all()
    assert (motion.positions[:, 0] > PANDA.upper[0] - 2e-3).sum() > 100


def test_rounding_beyond_the_limit_and_a_tolerance_wider_than_a_joint_are_borne():
    times, q = swing(0.0)
    q[:, 0] += 5e-10
    assert lt.retime(lt.JointTrajectory(times, q), PANDA).duration < 4.0
    upper = PANDA.upper.copy()
    upper[1] = PANDA.lower[1] + 0.01
    narrow = replace(PANDA, upper=upper)
    q[:, 1] = upper[1] - 0.01 * np.sin(0.5 * np.pi * times) ** 2
    motion = lt.retime(lt.JointTrajectory(times, q), narrow, path_tolerance=0.012)
    assert (motion.positions >= narrow.lower - 1e-9).all()
    assert (motion.positions <= narrow.upper + 1e-9).all()


def test_what_leaves_a_limit_is_refused_with_the_amount():
    times, q = swing(0.01)
    beyond = 0.01 * (PANDA.upper[0] - MIDDLE[0])
    with pytest.raises(LimitsInfeasible, match=rf"position limits .* by {beyond:.2g}"):
        lt.retime(lt.JointTrajectory(times, q), PANDA)


def test_a_smooth_path_that_leaves_limits_which_samples_touch_is_not_taken():
    q = np.random.default_rng(7).normal(0.0, 1.0, (4, 3))
    rates = [2.0] * 3, [10.0] * 3, [np.inf] * 3
    limits = lt.arm.JointLimits(["a", "b", "c"], q.min(axis=0), q.max(axis=0), *rates)
    path = lt.JointTrajectory(0.5 * np.arange(4), q)
    durations = [
        lt.retime(path, limits, rate=100.0, path_tolerance=tolerance).duration
        for tolerance in (1e-5, 1e-3, 1e-2, 0.1)
    ]
    assert (np.diff(durations) <= 0.0).all()
