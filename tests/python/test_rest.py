"""Standing still before and after a motion is left out, whatever the recording's noise."""

import math

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.preprocess import clean, segment, trim

BEFORE, AFTER, MOTION = 0.8, 0.9, 2.5  # s
EXACTLY = 0.12  # s, how exactly the ends of a rest are found


def recorded(rng, *, noise=0.0, rate=100.0, pause=0.0, before=BEFORE, after=AFTER, joints=3):
    """A reach of 0.4 m between two rests, perhaps with a pause in its middle."""
    knots = np.cumsum([0.0, before, 0.5 * MOTION, pause, 0.5 * MOTION, after])
    times = np.arange(0.0, knots[-1], 1.0 / rate)
    part = np.interp(times, knots, [0.0, 0.0, 0.5, 0.5, 1.0, 1.0])
    way = np.outer(lt.trajectories.minimum_jerk_time_scaling(part), np.linspace(0.3, -0.2, joints))
    return lt.Trajectory(times, way + rng.normal(0.0, noise, way.shape))


def left_out(whole, **settings):
    kept = trim(whole, **settings).motion
    return kept.times[0] - whole.times[0], whole.times[-1] - kept.times[-1]


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-4, 1e-3, 3e-3])
def test_rests_are_left_out_at_every_level_of_noise(noise, rate):
    rng = np.random.default_rng(1)
    for joints, pause in ((1, 0.0), (3, 0.0), (7, 1.5)):
        whole = recorded(rng, noise=noise, rate=rate, pause=pause, joints=joints)
        allowed = EXACTLY * (1.0 if noise < 3e-3 else 2.0)
        assert left_out(whole) == pytest.approx((BEFORE, AFTER), abs=allowed)


def test_a_motion_without_rests_loses_nothing_that_is_seen():
    rng = np.random.default_rng(2)
    for noise in (0.0, 1e-5, 1e-3):
        whole = recorded(rng, noise=noise, before=0.0, after=0.0)
        kept = trim(whole).motion
        for end in (0, -1):
            lost = np.linalg.norm(kept.positions[end] - whole.positions[end])
            assert lost < 0.004 + 6.0 * noise


def test_pauses_in_the_middle_stay():
    whole = recorded(np.random.default_rng(3), noise=3e-4, pause=1.5)
    kept = trim(whole).motion
    assert kept.duration == pytest.approx(MOTION + 1.5, abs=2.0 * EXACTLY)
    assert len(segment(kept)) == 2


def test_a_turn_on_the_spot_is_a_motion():
    times = np.arange(0.0, 4.0, 0.01)
    part = lt.trajectories.minimum_jerk_time_scaling(np.clip((times - 1.0) / 2.0, 0.0, 1.0))
    turned = lt.rotations.exp(np.outer(part, [0.0, 0.0, 1.2]))
    points = np.random.default_rng(4).normal(0.0, 2e-4, (len(times), 3))
    poses = lt.PoseTrajectory(times, points, turned)
    assert left_out(poses) == pytest.approx((1.0, 1.0), abs=EXACTLY)


def test_what_never_moves_stays_whole():
    rng = np.random.default_rng(5)
    for noise in (0.0, 1e-3):
        still = lt.Trajectory(np.arange(200) / 100.0, rng.normal(0.0, noise, (200, 3)))
        assert len(trim(still).motion) == 200
    assert len(trim(lt.Trajectory([0.0], [[1.0]])).motion) == 1
    assert len(trim(lt.Trajectory([0.0, 1.0], [[1.0], [2.0]])).motion) == 2


def test_events_within_a_rest_come_with_the_motions_ends():
    whole = recorded(np.random.default_rng(6))
    happened = [lt.Event(0.1, "open"), lt.Event(2.0, "turn"), lt.Event(4.1, "close")]
    shown = lt.Demonstration(lt.Trajectory(whole.times, whole.positions, happened), "reach")
    kept = trim(shown)
    assert kept.name == "reach"
    assert [event.name for event in kept.events] == ["open", "turn", "close"]
    first, middle, last = (event.time for event in kept.events)
    assert (first, middle, last) == (kept.motion.times[0], 2.0, kept.motion.times[-1])


def test_some_rest_is_kept_on_demand():
    whole = recorded(np.random.default_rng(7), noise=1e-4)
    all_out, some_out = left_out(whole), left_out(whole, rest=0.3)
    assert np.subtract(all_out, some_out) == pytest.approx((0.3, 0.3), abs=0.011)
    assert left_out(whole, rest=math.inf) == (0.0, 0.0)
    demonstration, report = clean(whole, rest=0.3)
    assert report.still == pytest.approx(some_out)
    assert "standing still before the motion" in str(report)
    assert demonstration.motion.duration == pytest.approx(whole.duration - sum(report.still))


def test_the_speed_may_be_stated():
    whole = recorded(np.random.default_rng(8), noise=1e-4)
    assert min(left_out(whole, speed=0.2)) > max(left_out(whole, speed=0.01)) - 0.05
    for name in ("speed", "angular_speed", "rest"):
        for value in (-1.0, math.nan, "fast"):
            refused(f"{name}: ", trim, whole, **{name: value})


def test_real_demonstrations_keep_their_motion(recordings):
    """Tasks guided by hand: the parts left out at the ends are next to nothing of the path."""
    rests = []
    for task in ("bottle2shelf", "pouring"):
        for rows in np.load(recordings / "robotasks" / f"{task}.npy"):
            turned = rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
            times = np.linspace(0.0, 10.0, len(rows))
            whole = lt.PoseTrajectory(times, rows[:, :3] / 100.0, turned)
            assert length(whole) - length(trim(whole).motion) < 0.01 * length(whole)
            rests.append(left_out(whole))
    assert np.max(rests, axis=0)[0] < 0.2  # they start at once
    assert np.max(rests, axis=0)[1] > 1.0  # some stand still at the end


def length(motion):
    return np.linalg.norm(np.diff(motion.positions, axis=0), axis=1).sum()


@pytest.mark.parametrize("size", [1e155, 1e300, 1e-200])
def test_numbers_of_a_damaged_file_stay_whole(size):
    times = np.arange(200) / 100.0
    points = lt.Trajectory(times, size * np.random.default_rng(10).normal(size=(200, 3)))
    assert len(trim(points).motion) == 200
