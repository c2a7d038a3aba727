"""A motion paused, resumed and slowed down stays on its path and inside the limits."""

import numpy as np
import pytest
from guard.adversary import HOMES
from guard.judge import EXCESS, worst_use
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput, LimitsInfeasible, NoPath
from leadthrough.guard import CommandedState, Playback, playback

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
    with pytest.raises(InvalidInput, match=r"^motion: expected the joints shoulder_pan_joint"):
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


Q = HOMES["panda"]
HERTZ = 100.0
TIMES = np.arange(0, 100) / HERTZ
MOVING = Q + 0.2 * np.outer(np.sin(2.0 * TIMES + 0.3), np.linspace(1.0, 0.2, 7))


def motion_of(rows, **more):
    return lt.JointTrajectory(TIMES[: len(rows)], rows, **more)


def test_a_motion_cut_out_of_another_begins_and_ends_at_rest(panda):
    whole = lt.connect(Q - 0.1, motion_of(MOVING), panda)
    assert np.array_equal(whole.positions[0], Q - 0.1)
    assert worst_use(whole.positions, panda.limits, HERTZ) <= 1.0 + EXCESS
    assert lt.check_limits(whole, panda.limits).ok
    begin = int(np.abs(whole.positions - MOVING[0]).max(axis=1).argmin())
    assert np.array_equal(whole.positions[begin : begin + 100], MOVING)
    assert not whole.velocities[-1].any()
    assert not whole.accelerations[-1].any()


def test_a_moving_arm_is_taken_along(panda):
    state = CommandedState(Q, np.full(7, 0.4), np.zeros(7))
    whole = lt.connect(state, motion_of(MOVING), panda)
    before = np.array([Q - 0.8 / HERTZ, Q - 0.4 / HERTZ])
    rows = np.concatenate([before, whole.positions])
    for order, limit in ((2, panda.limits.acceleration), (3, panda.limits.jerk)):
        used = np.abs(np.diff(rows, order, axis=0)) * HERTZ**order / limit
        assert used.max() <= 1.0 + EXCESS


def test_the_result_can_be_written_for_a_controller(panda, tmp_path):
    whole = lt.connect(Q, motion_of(MOVING, joint_names=panda.joint_names), panda)
    lt.write_motion(whole, tmp_path / "whole.json")
    assert (tmp_path / "whole.json").exists()


def test_events_stay_where_they_were_on_the_motion(panda):
    event = lt.Event(0.5, "closed")
    whole = lt.connect(Q, motion_of(MOVING, events=[event]), panda)
    (moved,) = whole.events
    assert np.allclose(whole.at(moved.time), motion_of(MOVING).at(0.5), atol=1e-9)


def test_whole_turns_are_taken_the_short_way():
    ur3 = lt.Arm.load("ur3")
    q = HOMES["ur3"]
    rows = np.repeat(q[None], 20, axis=0)
    rows[:, 0] += 2.0 * np.pi - 0.1
    rows[:, 5] += 6.0 * np.pi
    whole = lt.connect(q, motion_of(rows), ur3)
    assert np.abs(whole.positions - q).max() <= 0.1 + 1e-9
    assert np.allclose(np.exp(1j * whole.positions[-1]), np.exp(1j * rows[-1]))


def test_a_way_that_is_not_clear_names_the_bodies(panda):
    far = Q + np.array([1.5, 0, 0, 0, 0, 0, 0])
    between = panda.forward_kinematics(Q + np.array([0.75, 0, 0, 0, 0, 0, 0]))[0]
    rows = np.repeat(far[None], 10, axis=0)
    with pytest.raises(NoPath, match=r"bridge onto .* is not clear: obstacle 0") as found:
        lt.connect(Q, motion_of(rows), panda, [lt.Sphere(0.05, between)])
    assert found.value.reason == "ease_in"


def test_an_end_too_fast_to_brake_is_infeasible(panda):
    rows = np.repeat(Q[None], 30, axis=0)
    rows[:, 0] = panda.limits.upper[0] - 0.015 * np.arange(30)[::-1]
    with pytest.raises(LimitsInfeasible, match="panda_joint1"):
        lt.connect(rows[0], motion_of(rows), panda)


def test_wrong_ends_of_a_connection_are_named(panda):
    refused("trajectory: expected a JointTrajectory", lt.connect, Q, MOVING, panda)
    with pytest.raises(InvalidInput, match="trajectory: expected at least two samples"):
        lt.connect(Q, motion_of(MOVING[:1]), panda)
    refused("state: expected shape", lt.connect, Q[:2], motion_of(MOVING), panda)


def test_a_push_on_a_compliant_arm_corrects_its_skill(panda):
    """A hand lifts the tip for 0.4 s: the corrected skill goes there, and elsewhere as before."""
    way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))
    rows = HOMES["panda"] + np.outer(way, AWAY)
    times = np.linspace(0.0, 3.0, 101)
    shown = lt.JointTrajectory(times, rows, joint_names=panda.joint_names)
    skill = lt.DMP().fit([panda.poses(shown)])
    motion = lt.keep_timing(panda.follow(skill.generate()), panda.limits, rate=RATE)
    play = Playback(motion, panda.limits, rate=RATE)
    hand = lt.simulation.Push(1.4, (0.0, 0.0, 40.0), 0.4)
    real = lt.simulation.SimulatedArm(
        panda,
        motion.positions[0],
        controller=lt.simulation.JointImpedance(),
        disturbances=lt.simulation.Disturbances(pushes=[hand]),
    )
    guard = lt.Guard(panda, rate=RATE)
    guard.admit(real.q[None], state=real.q)
    assert play.push is None
    while not play.done:
        guard.admit(play.next(measured=real.q)[None])
        real.step(guard.next())

    assert hand.time < play.push.time < hand.time + hand.duration + 0.2
    commanded, measured = (
        panda.forward_kinematics(q)[0] for q in (play.push.commanded, play.push.measured)
    )
    assert measured[2] - commanded[2] > 0.02
    before, after = skill.generate(), skill.corrected(commanded, measured).generate()
    gaps = [np.linalg.norm(each.positions - measured, axis=1).min() for each in (before, after)]
    assert gaps[1] < 0.1 * gaps[0]
    covered = lt.preprocess.arc_length(before.positions) / np.sum(
        np.linalg.norm(np.diff(before.positions, axis=0), axis=1)
    )
    at = covered[np.linalg.norm(before.positions - commanded, axis=1).argmin()]
    far = np.abs(covered - at) > 0.21
    assert np.linalg.norm(after.positions - before.positions, axis=1)[far].max() < 0.002


def test_measured_joints_that_do_not_fit_are_refused(panda, motion):
    play = Playback(motion, panda.limits, rate=RATE)
    refused("measured", play.next, [0.0, 0.0])
    refused("measured", play.next, np.full(7, np.nan))
