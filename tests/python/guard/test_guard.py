"""A guard's verdicts: chunks allowed, changed and refused, with the reasons."""

import copy
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from guard.adversary import HOMES, RATE, smooth
from guard.judge import EXCESS, worst_use
from refusals import refused
from scipy.interpolate import CubicHermiteSpline, CubicSpline

import leadthrough as lt
from leadthrough.guard import CommandedState
from leadthrough.guard.admission import chunk_of
from leadthrough.guard.connect import changed
from leadthrough.guard.rules import rules_for
from leadthrough.shapes import MovingObstacle

Q = HOMES["panda"]
PERIOD = 1.0 / RATE
TIMES = PERIOD * np.arange(1, 51)
WALL = lt.Box([0.02, 2.0, 2.0], [0.6, 0.0, 0.5])


@pytest.fixture
def guard(panda):
    return lt.Guard(panda, [WALL], rate=RATE)


def wave(size, turns=0.5):
    return Q + size * (1.0 - np.cos(2.0 * np.pi * turns * TIMES[:, None])) * np.linspace(0.2, 1, 7)


def run(guard, count):
    return np.array([guard.next().q for _ in range(count)])


def finished(guard):
    """All that is left to command, to rest, behind the command now."""
    return np.concatenate([guard.state.q[None], run(guard, guard.remaining + 1)])


def assert_kept(panda, rows):
    assert worst_use(rows, panda.limits, RATE) <= 1.0 + EXCESS
    assert panda.check(rows, [WALL]).ok


def test_a_chunk_that_is_allowed_passes_to_the_bit(panda, guard):
    rows = wave(0.1)
    answer = guard.admit(rows, Q)
    assert (answer.verdict, answer.safe, answer.reasons) == ("allowed", True, ())
    assert np.array_equal(answer.motion.positions, rows)
    assert np.array_equal(run(guard, 50), rows)
    assert np.array_equal(run(guard, len(answer.brake)), answer.brake.positions)
    assert_kept(panda, np.concatenate([Q[None], rows, answer.brake.positions]))


def test_a_trajectory_that_is_allowed_comes_back_with_its_own_rates(panda, guard):
    times = np.append(0.0, TIMES)[:, None]
    rates = [
        0.1 * np.linspace(0.2, 1, 7) * each
        for each in (np.pi * np.sin(np.pi * times), np.pi**2 * np.cos(np.pi * times))
    ]
    rates[1][0] = 0.0
    motion = lt.JointTrajectory(TIMES, wave(0.1), *(each[1:] for each in rates))
    found = guard.admit(motion, Q)
    assert found.verdict == "allowed"
    for part in ("positions", "velocities", "accelerations"):
        assert np.array_equal(getattr(found.motion, part), getattr(motion, part))


def test_rates_that_belong_to_another_motion_are_replaced(panda, guard):
    wrong = np.full((50, 7), 0.3)
    motion = lt.JointTrajectory(TIMES, wave(0.1), wrong, wrong)
    found = guard.admit(motion, Q)
    assert found.verdict == "allowed"
    assert np.array_equal(found.motion.positions, motion.positions)
    middle = (motion.positions[2:] - motion.positions[:-2]) / (2.0 * PERIOD)
    np.testing.assert_allclose(found.motion.velocities[1:-1], middle, atol=1e-9)


def test_without_a_new_chunk_the_arm_brakes_and_rests(panda, guard):
    guard.admit(wave(0.2)[:20], Q)
    rows = finished(guard)
    assert len(rows) > 21
    assert_kept(panda, rows)
    still = guard.next()
    assert np.array_equal(still.q, rows[-1])
    assert not still.qd.any()


def test_a_jump_is_bridged_and_named(panda, guard):
    rows = wave(0.1)
    rows[20:] += 0.3
    answer = guard.admit(rows, Q)
    assert answer.verdict == "changed"
    assert (answer.reasons[0].kind, answer.reasons[0].time) == ("jump", pytest.approx(0.42))
    assert answer.reasons[0].joint == "panda_joint1"
    assert np.array_equal(answer.motion.positions[:20], rows[:20])
    assert np.allclose(answer.motion.positions[-20:], rows[-20:], atol=1e-12)
    assert_kept(panda, finished(guard))


def test_a_fast_step_beside_one_as_fast_is_no_jump(panda, guard):
    most = panda.limits.velocity[0] * PERIOD
    rows = np.tile(Q, (50, 1))
    rows[:, 0] += most * np.concatenate([[0.9, 1.95], np.full(48, 2.0)])
    kinds = {reason.kind for reason in guard.admit(rows, Q).reasons}
    assert "velocity" in kinds
    assert "jump" not in kinds


def test_a_bridge_takes_even_steps_from_one_sample_to_the_next(panda):
    rows = wave(0.1)
    rows[20:] += 0.3
    rules = rules_for(panda, lt.Scene(), PERIOD)
    places = changed(rules, np.append(Q, np.zeros(14))[None], rows).places
    bridge = places[(places >= 19.0) & (places <= 20.0)]
    assert len(bridge) > 10
    np.testing.assert_allclose(bridge, np.linspace(19.0, 20.0, len(bridge)), atol=1e-12)
    np.testing.assert_array_equal(places[places > 20.0], np.arange(21.0, 50.0))


def test_a_chunk_that_is_too_fast_keeps_its_path(panda, guard):
    fast = wave(0.25, turns=2.0)
    answer = guard.admit(fast, Q)
    assert answer.verdict == "changed"
    assert "acceleration" in {reason.kind for reason in answer.reasons}
    # The joints of a wave move in proportion.
    moved = answer.motion.positions - Q
    along = moved[:, -1:] * np.linspace(0.2, 1, 7)
    assert np.abs(moved - along).max() < 1e-3
    assert np.abs(answer.motion.positions - fast[-1]).max(axis=1).min() < 1e-3
    assert_kept(panda, finished(guard))


def test_positions_stay_inside_their_limits(panda, guard):
    out = Q + np.outer(TIMES, [0, 0, 0, 2.2, 0, 0, 0])
    answer = guard.admit(out, Q)
    assert "position" in {reason.kind for reason in answer.reasons}
    rows = finished(guard)
    assert rows[:, 3].max() <= panda.limits.upper[3]
    assert_kept(panda, rows)


@pytest.fixture(scope="module")
def hit(panda):
    """A motion of the tip straight into the wall."""
    start, turned = panda.forward_kinematics(Q)
    goal = [0.65, 0.0, start[2]]
    share = np.linspace(0.0, 1.0, 51)[:, None]
    ease = share**2 * (3.0 - 2.0 * share)
    way = lt.PoseTrajectory(3.0 * share[:, 0], start + ease * (goal - start), [turned] * 51)
    followed = panda.follow(way, q0=Q)
    fast = lt.retime(followed, panda.limits, rate=3.0 * RATE)
    return lt.JointTrajectory(3.0 * fast.times, fast.positions, joint_names=panda.joint_names)


def test_a_motion_is_cut_before_a_contact(panda, guard, hit):
    assert not panda.check(hit, [WALL]).ok
    answer = guard.admit(hit, hit.positions[0])
    assert (answer.verdict, answer.safe) == ("changed", True)
    (reason,) = (reason for reason in answer.reasons if reason.kind == "contact")
    assert reason.bodies[0] == "obstacle 0"
    kept = len(answer.motion)
    assert np.array_equal(answer.motion.positions, hit.positions[:kept])
    rows = finished(guard)
    assert_kept(panda, rows)
    assert panda.distance(rows[-1], [WALL]) < 0.05


def test_nan_refuses_the_chunk_and_brakes(panda, guard):
    guard.admit(wave(0.2), Q)
    before = run(guard, 20)
    bad = wave(0.2)
    bad[3, 2] = np.nan
    answer = guard.admit(bad)
    assert (answer.verdict, answer.safe) == ("braking", True)
    assert str(answer.reasons[0]) == "a value of panda_joint3 is not finite at 0.080 s"
    assert_kept(panda, np.concatenate([Q[None], before, finished(guard)[1:]]))


def test_chunks_replace_each_other_on_their_clock(panda, guard):
    """Temporal ensembling: each chunk overlaps the one before and is a little off it."""
    whole = np.concatenate([wave(0.15, turns=0.4), wave(0.15, turns=0.4)[::-1]])
    rng = np.random.default_rng(3)
    commanded = [Q]
    guard.admit(whole[:50], Q)
    for start in range(10, 50, 10):
        commanded.extend(run(guard, 10))
        answer = guard.admit(whole[start : start + 50] + rng.normal(0.0, 2e-4, 7))
        assert answer.verdict in ("allowed", "changed")
        assert len(answer.motion) == 50
    commanded.extend(finished(guard)[1:])
    assert_kept(panda, np.array(commanded))


def test_an_obstacle_that_appears_shortens_what_was_admitted(panda, hit):
    guard = lt.Guard(panda, rate=RATE)
    assert guard.admit(hit, hit.positions[0]).verdict == "allowed"
    before = run(guard, 10)
    answer = guard.update_obstacles([WALL])
    assert (answer.verdict, answer.safe) == ("changed", True)
    assert answer.reasons[0].bodies[0] == "obstacle 0"
    assert_kept(panda, np.concatenate([hit.positions[:1], before, finished(guard)[1:]]))


def test_an_obstacle_too_near_to_brake_for_is_reported_and_braked_for(panda, hit):
    guard = lt.Guard(panda, rate=RATE)
    guard.admit(hit, hit.positions[0])
    fastest = int(np.abs(np.diff(hit.positions, axis=0)).max(axis=1).argmax())
    before = run(guard, fastest)
    left = guard.remaining
    tip = panda.forward_kinematics(guard.state.q + 0.04 * guard.state.qd)[0]
    answer = guard.update_obstacles([lt.Sphere(0.02, tip)])
    assert (answer.verdict, answer.safe, guard.safe) == ("braking", False, False)
    assert answer.reasons[-1].kind == "contact"
    assert "NOT SAFE" in str(answer)
    assert guard.remaining < left
    rows = np.concatenate([hit.positions[:1], before, finished(guard)[1:]])
    assert worst_use(rows, panda.limits, RATE) <= 1.0 + EXCESS


def test_an_obstacle_that_moves_needs_more_room_the_later_it_is_met(panda, hit):
    kept = []
    for speed in (0.0, 0.05, 0.2):
        guard = lt.Guard(panda, [MovingObstacle(WALL, speed)], rate=RATE)
        kept.append(len(guard.admit(hit, hit.positions[0]).motion))
    assert kept[0] > kept[1] > kept[2]


def test_what_was_seen_long_ago_counts_as_having_moved(panda, hit):
    guard = lt.Guard(panda, [MovingObstacle(WALL, 0.1)], rate=RATE)
    guard.admit(Q[None], Q)
    early = len(guard.admit(hit).motion)
    guard.stop()
    run(guard, 100)
    late = len(guard.admit(hit).motion)
    assert late < early
    guard.update_obstacles([MovingObstacle(WALL, 0.1)])
    assert len(guard.admit(hit).motion) == early


def test_stopping_is_the_fastest_motion_to_rest(panda, guard):
    guard.admit(wave(0.3), Q)
    run(guard, 25)
    speed = np.abs(guard.state.qd / panda.limits.acceleration).max()
    answer = guard.stop()
    assert answer.verdict == "braking"
    assert len(answer.motion) <= np.ceil(speed * RATE) + 2


def test_a_chunk_at_another_rate_is_put_on_the_guards_clock(panda, guard):
    times = np.linspace(0.1, 1.0, 10)
    slow = lt.JointTrajectory(times, np.asarray(Q + 0.05 * np.outer(1 - np.cos(times), np.ones(7))))
    answer = guard.admit(slow, slow.positions[0])
    assert "resampled" in {reason.kind for reason in answer.reasons}
    assert len(answer.motion) == 46
    assert np.abs(answer.motion.at(slow.times[1:-1]) - slow.positions[1:-1]).max() < 1e-3


@pytest.mark.parametrize("rated", [True, False])
def test_samples_of_another_clock_lie_on_scipys_cubics(panda, rated):
    times = np.cumsum(np.random.default_rng(0).uniform(0.02, 0.1, 20))
    rows, slopes = np.sin(times)[:, None] * np.ones(7), np.cos(times)[:, None] * np.ones(7)
    motion = lt.JointTrajectory(times, rows, slopes if rated else None)
    cubic = CubicHermiteSpline(times, rows, slopes) if rated else CubicSpline(times, rows)
    made = chunk_of(motion, panda, PERIOD)
    at = times[0] + PERIOD * np.arange(len(made.rows))
    assert made.resampled and made.whole
    assert np.abs(made.rows - cubic(at)).max() < 1e-12


def test_a_guards_loop_imports_no_scipy():
    program = (
        "import sys, numpy as np, leadthrough as lt\n"
        "arm, q = lt.Arm.load('panda'), np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])\n"
        "guard = lt.Guard(arm, [lt.Sphere(0.1, [0.0, 0.9, 0.5])], rate=500.0)\n"
        "before = set(sys.modules)\n"
        "guard.admit(lt.JointTrajectory([0.0, 1.0], [q, q + 0.1]), q)\n"
        "guard.admit(q + np.random.default_rng(0).normal(size=(99, 7)))\n"
        "assert not {name for name in set(sys.modules) - before if 'scipy' in name}\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)


def test_long_chunks_are_admitted_as_far_as_the_time_allows(panda):
    """Two samples a thousand seconds apart, and noise that would last for minutes."""
    far = lt.JointTrajectory([0.0, 1000.0], [Q, np.asarray(Q) + 0.1])
    answer = lt.Guard(panda, [WALL], rate=RATE).admit(far, Q)
    assert [each.kind for each in answer.reasons] == ["resampled", "cut short"]
    assert answer.reasons[-1].time == pytest.approx(4095 * PERIOD)
    assert len(answer.motion) == 4096 and answer.safe
    noise = Q + np.random.default_rng(0).normal(0.0, 0.2, (2000, 7))
    answer = lt.Guard(panda, rate=RATE).admit(noise, Q)
    assert "cut short" in {each.kind for each in answer.reasons} and answer.safe
    assert len(answer.to_rest) < 4096
    whole = lt.Guard(panda, rate=RATE, max_samples=10**6).admit(far, Q)
    assert len(whole.motion) == 50001
    refused("max_samples", lt.Guard, panda, rate=RATE, max_samples=15)


def test_events_keep_their_place_on_the_motion(panda, guard):
    events = [lt.Event(0.5, "closed")]
    rows = wave(0.1)
    motion = lt.JointTrajectory(TIMES, rows, joint_names=panda.joint_names, events=events)
    assert guard.admit(motion, Q).motion.events == tuple(events)
    jumped = rows.copy()
    jumped[10:] += 0.3
    late = lt.JointTrajectory(TIMES, jumped, joint_names=panda.joint_names, events=events)
    (event,) = guard.admit(late, Q).motion.events
    assert 0.7 < event.time < 1.0


def test_a_state_that_no_motion_can_save_is_said_to_be_unsafe(panda, guard):
    q = np.array(Q)
    q[0] = panda.limits.upper[0] - 0.01
    fast = CommandedState(q, np.eye(7)[0] * 2.0, np.zeros(7))
    answer = guard.admit(q[None], fast)
    assert (answer.verdict, answer.safe) == ("braking", False)
    assert answer.reasons[-1].kind == "position"


def test_an_arm_that_rests_where_it_may_not_is_said_to_be_unsafe(panda):
    beyond = Q.copy()
    beyond[3] = panda.limits.upper[3] + 0.1
    answer = lt.Guard(panda, rate=RATE).admit(Q + np.zeros((20, 7)), beyond)
    assert (answer.verdict, answer.safe) == ("braking", False)
    assert ("position", "panda_joint4") in {(each.kind, each.joint) for each in answer.reasons}
    ball = lt.Sphere(0.1, panda.forward_kinematics(Q)[0])
    standing = lt.Guard(panda, [ball], rate=RATE).admit(Q + np.zeros((20, 7)), Q)
    assert (standing.verdict, standing.safe) == ("braking", False)
    assert [each.kind for each in standing.reasons] == ["contact"]


def test_an_obstacle_that_appears_in_a_resting_arm_is_reported(panda, guard):
    guard.admit(Q[None], Q)
    guard.next()
    assert guard.update_obstacles([]).safe
    answer = guard.update_obstacles([lt.Sphere(0.1, panda.forward_kinematics(Q)[0])])
    assert (answer.safe, guard.safe) == (False, False)
    assert guard.update_obstacles([]).safe


def test_equal_calls_have_equal_answers(panda):
    def stream():
        guard = lt.Guard(panda, [WALL], rate=RATE)
        rng = np.random.default_rng(5)
        guard.admit(Q[None], Q)
        rows = []
        for _ in range(5):
            guard.admit(smooth(rng, guard.state.q, size=1.0))
            rows.append(run(guard, 9))
        return np.concatenate(rows)

    assert np.array_equal(stream(), stream())


def test_wrong_arguments_are_named(guard, panda):
    for arguments, message in [
        ({"chunk": np.zeros((3, 6)), "state": Q}, r"chunk: expected shape \(n, 7\)"),
        ({"chunk": np.zeros((0, 7)), "state": Q}, "chunk: expected at least one sample"),
        ({"chunk": np.zeros((3, 7))}, "state: expected the joints at the first call"),
        ({"chunk": np.zeros((3, 7)), "state": Q[:3]}, r"state: expected shape \(7,\)"),
    ]:
        refused(message, guard.admit, **arguments)
    bare = lt.Arm.from_urdf(panda.document, base=panda.base, tip=panda.tip)
    refused("limits: expected acceleration limits", lt.Guard, bare, rate=RATE)
    refused("arm: expected an Arm, got 'panda'", lt.Guard, "panda", rate=RATE)


def test_a_way_that_grazes_for_long_is_certified_as_far_as_the_work_allows(panda, monkeypatch):
    """Less work, a shorter answer; it is safe all the same, and says how far it was looked at."""
    rows = wave(2.0)
    lengths = []
    for work in (200, 40, 0):
        monkeypatch.setattr("leadthrough.guard.guard._WORK", work)
        guard = lt.Guard(panda, [WALL], rate=RATE)
        answer = guard.admit(rows, Q)
        assert answer.safe
        assert_kept(panda, finished(guard))
        assert ("cut short" in [each.kind for each in answer.reasons]) == (work < 200)
        lengths.append(len(answer.motion) if answer.verdict == "changed" else 0)
    assert lengths[0] > lengths[1] > lengths[2] == 0
    assert "only the way up to 0.020 s was certified" in str(answer)


def test_a_stop_that_leaves_a_limit_is_reported_when_it_does(panda):
    """The last sample is half a step before the end of joint 7's range."""
    step = np.eye(7)[6] / RATE  # at 1 rad/s
    last = np.where(np.eye(7)[6], panda.limits.upper - 0.5 * step, Q)
    rows = last - step * np.arange(9, -1, -1)[:, None]
    state = CommandedState(rows[0] - step, step * RATE, np.zeros(7))
    answer = lt.Guard(panda, rate=RATE).admit(rows, state)
    reason = answer.reasons[-1]
    assert (reason.kind, reason.joint) == ("position", "panda_joint7")
    assert reason.time == pytest.approx(11 * PERIOD)


@pytest.mark.parametrize(
    ("q", "qd", "qdd"),
    [
        ([np.nan], [0.0], [0.0]),
        ([0.0], [0.0, 0.0], [0.0]),
        ([0.0], [0.0], ["fast"]),
        (0.0, 0.0, 0.0),
    ],
)
def test_a_commanded_state_that_is_none_is_refused(q, qd, qdd):
    refused(r"^q(d|dd)?: expected", CommandedState, q, qd, qdd)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))])
def test_a_copied_guard_goes_on_as_the_one_it_was_copied_from(guard, copied):
    guard.admit(wave(0.2), Q)
    run(guard, 20)
    other = copied(guard)
    assert np.array_equal(run(guard, 5), run(other, 5))
    rows = wave(0.3)
    mine, theirs = guard.admit(rows), other.admit(rows)
    assert str(mine) == str(theirs)
    assert np.array_equal(mine.to_rest.positions, theirs.to_rest.positions)


@pytest.mark.parametrize("turns", [0.5, 1.0, 2.0])
def test_torques_with_the_payload_stay_inside_their_limits(panda, turns):
    """Of chunks that exceed them on purpose: they are slowed, up to the rest at their end."""
    loaded, rows = panda.with_payload(2.0, (0.0, 0.0, 0.05)), wave(0.3, turns)

    def torques(motion):
        return loaded.inverse_dynamics(motion.positions, motion.velocities, motion.accelerations)

    free = lt.Guard(loaded, rate=RATE).admit(rows, Q).to_rest
    held = np.abs(loaded.gravity_torques(free.positions)).max(axis=0)
    effort = np.maximum(0.9 * np.abs(torques(free)).max(axis=0), 1.02 * held)
    weak = replace(loaded, limits=replace(loaded.limits, effort=effort))
    guard = lt.Guard(weak, rate=RATE, inverse_dynamics=loaded.inverse_dynamics)
    answer = guard.admit(rows, Q)
    assert answer.safe and answer.verdict == "changed" and len(answer.motion)
    (reason,) = (each for each in answer.reasons if each.kind == "torque")
    assert reason.ratio > 1.0
    assert f"{reason.joint} exceeds its torque limit at" in str(reason)
    assert (np.abs(torques(answer.to_rest)) <= effort).all()
    assert pickle.loads(pickle.dumps(guard)).admit(rows).verdict == guard.admit(rows).verdict


def test_torques_are_only_bounded_where_limits_are_known(panda):
    unknown = replace(panda, limits=replace(panda.limits, effort=None))
    refused(
        "limits: expected effort limits beside inverse_dynamics",
        lt.Guard,
        unknown,
        rate=RATE,
        inverse_dynamics=panda.inverse_dynamics,
    )
    effort = panda.limits.effort.copy()
    effort[2] = 0.0
    refused(
        "limits: expected effort limits > 0 beside inverse_dynamics, got 0 of panda_joint3",
        lt.Guard,
        replace(panda, limits=replace(panda.limits, effort=effort)),
        rate=RATE,
        inverse_dynamics=panda.inverse_dynamics,
    )
    refused("inverse_dynamics: expected a function", lt.Guard, panda, rate=RATE, inverse_dynamics=1)
