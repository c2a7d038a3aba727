"""A motion paused, resumed and slowed down stays on its path and inside the limits."""

import numpy as np
import pytest
from guard.adversary import HOMES
from guard.judge import EXCESS, worst_use
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.guard import Playback, playback

RATE = 1000.0
AWAY = np.array([0.8, 0.4, -0.4, 0.5, 0.3, -0.4, 0.6])


def limits_of(arm, part):
    values = {name: part * getattr(arm.limits, name) for name in ("acceleration", "jerk")}
    return lt.arm.JointLimits(
        **vars(arm.limits) | values | {"velocity": part * arm.limits.velocity}
    )


@pytest.fixture(scope="module")
def motion(panda):
    way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))
    return lt.retime(HOMES["panda"] + np.outer(way, AWAY), limits_of(panda, 0.5))


def played(play, words, ticks=4000):
    rows, times = [], []
    for tick in range(ticks):
        word = words.get(tick)
        if isinstance(word, float):
            play.speed = word
        elif word is not None:
            getattr(play, word)()
        rows.append(play.next())
        times.append(play.time)
        if play.done:
            break
    return np.array(rows), np.array(times)


def test_left_alone_it_is_the_motion(panda, motion):
    rows, _ = played(Playback(motion, panda.limits, rate=RATE), {})
    assert np.abs(rows - motion.positions[1 : len(rows) + 1]).max() < 1e-9
    assert len(rows) == len(motion) - 1


def test_it_stays_on_its_path_and_inside_the_limits(panda, motion):
    play = Playback(motion, panda.limits, rate=RATE)
    words = {150: "pause", 700: "resume", 900: 0.4, 1300: 1.0, 1500: "pause", 1550: "resume"}
    rows, times = played(play, words)
    assert play.done
    whole = np.concatenate([motion.positions[:1], rows])
    assert worst_use(whole, panda.limits, RATE) <= 1.0 + EXCESS
    on_path = [np.interp(times, motion.times, column) for column in motion.positions.T]
    assert np.abs(rows - np.column_stack(on_path)).max() < 1e-5
    assert np.array_equal(rows[690], rows[680])
    assert (np.diff(times) >= 0.0).all()


def test_what_it_plays_is_admitted_as_it_is(panda, motion):
    guard = lt.Guard(panda, rate=RATE)
    guard.admit(motion.positions[:1], state=motion.positions[0])
    play = Playback(motion, panda.limits, rate=RATE)
    for tick in range(600):
        if tick == 200:
            play.pause()
        assert guard.admit(play.next()[None]).verdict == "allowed"
        guard.next()
    assert play.paused and play.speed_now == 0.0


def test_wrong_arguments_are_named(panda, motion):
    refused(r"^rate", Playback, motion, panda.limits, rate=0.0)
    with pytest.raises(InvalidInput, match=r"^motion: expected 6 joints, got 7"):
        Playback(motion, lt.Arm.load("ur3").limits, rate=RATE)
    refused(r"^motion: .* at least two samples", Playback, motion[:1], panda.limits, rate=RATE)
    refused(r"^motion: expected room below the", Playback, motion, limits_of(panda, 0.5), rate=RATE)
    unknown = lt.arm.JointLimits(**vars(panda.limits) | {"jerk": None})
    refused(r"^limits: expected acceleration and jerk", Playback, motion, unknown, rate=RATE)
    play = Playback(motion, panda.limits, rate=RATE)
    with pytest.raises(InvalidInput, match=r"^speed"):
        play.speed = 1.5


def test_the_phase_may_change_by_what_the_motion_leaves_of_the_limits():
    # q = t^2 moves and bends by 2 at most: (A - 2) / 2 and J / 12 bound the phase's acceleration,
    # half of J / 2 its jerk.
    times = np.linspace(0.0, 1.0, 1001)
    motion = lt.JointTrajectory(times, times[:, None] ** 2, joint_names=["j"])
    for acceleration, jerk, bend, change in ((50.0, 6.0, 0.5, 1.5), (2.8, 60.0, 0.4, 15.0)):
        limits = lt.arm.JointLimits(["j"], [-9.0], [9.0], [9.0], [acceleration], [jerk])
        found = playback._phase_limits(motion, limits)
        np.testing.assert_allclose(found, (bend, change), rtol=0.01)
