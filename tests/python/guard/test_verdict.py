"""All that a guard admits, brakes and connects passes `check_limits`, by the quintics."""

import numpy as np
import pytest
from guard.adversary import HOMES, KINDS, chunk

import leadthrough as lt
from leadthrough.guard import CommandedState

ARMS = [("panda", 100.0), ("panda", 1000.0), ("ur3", 250.0), ("ur3", 1000.0), ("panda", 50.0)]


def motion_of(states, rate, names):
    """The commands of a stream that begins at rest."""
    parts = [np.array([getattr(state, part) for state in states]) for part in ("q", "qd", "qdd")]
    return lt.JointTrajectory(np.arange(len(states)) / rate, *parts, joint_names=names)


def near_limits(rng, q, limits, rate):
    """A wave whose velocity, acceleration or jerk is about at its limit."""
    turns = 2.0 * np.pi * 10.0 ** rng.uniform(-0.5, 1.0, len(q))
    largest = np.min(
        [limits.velocity / turns, limits.acceleration / turns**2, limits.jerk / turns**3], axis=0
    )
    times = np.arange(1, 61)[:, None] / rate
    return q + rng.uniform(0.5, 1.05) * largest * (1.0 - np.cos(turns * times)) / 2.0


def draw(rng, guard, limits):
    """A chunk of any kind from the guard's state on, also with rates and of single samples."""
    q = guard.state.q
    if rng.random() < 0.4:
        rows = near_limits(rng, q, limits, guard.rate)
    else:
        rows = chunk(rng, str(rng.choice(KINDS)), q)
    return rows[: int(rng.choice([1, 2, 3, 20, 60]))]


@pytest.mark.parametrize(("name", "rate"), ARMS)
def test_all_that_is_commanded_passes_the_check_of_limits(name, rate):
    arm = lt.Arm.load(name)
    rng = np.random.default_rng(7)
    for _ in range(3):
        guard = lt.Guard(arm, rate=rate)
        guard.admit(HOMES[name][None], HOMES[name])
        sent = [guard.state]
        for _ in range(40):
            answer = (
                guard.stop() if rng.random() < 0.1 else guard.admit(draw(rng, guard, arm.limits))
            )
            assert answer.safe
            sent.extend(guard.next() for _ in range(int(rng.integers(1, 30))))
        sent.extend(guard.next() for _ in range(guard.remaining))
        report = lt.check_limits(motion_of(sent, rate, arm.joint_names), arm.limits)
        assert report.ok, report


@pytest.mark.parametrize(("name", "rate"), ARMS)
def test_answers_from_rest_pass_the_check_of_limits(name, rate):
    arm = lt.Arm.load(name)
    rng = np.random.default_rng(8)
    for _ in range(40):
        guard = lt.Guard(arm, rate=rate)
        guard.admit(HOMES[name][None], HOMES[name])
        rest = guard.admit(draw(rng, guard, arm.limits)).to_rest
        first = CommandedState(HOMES[name], np.zeros(len(HOMES[name])), np.zeros(len(HOMES[name])))
        states = zip(rest.positions, rest.velocities, rest.accelerations, strict=True)
        whole = motion_of([first, *(CommandedState(*s) for s in states)], rate, arm.joint_names)
        assert lt.check_limits(whole, arm.limits).ok


@pytest.mark.parametrize(("name", "rate"), ARMS)
def test_a_motion_inside_the_limits_passes_to_the_bit_and_connected_it_stays_inside(name, rate):
    arm = lt.Arm.load(name)
    rng = np.random.default_rng(9)
    for _ in range(4):
        way = HOMES[name] + np.cumsum(rng.uniform(-0.4, 0.4, (4, len(HOMES[name]))), axis=0)
        timed = lt.retime(way, arm.limits, rate=rate)
        assert lt.check_limits(timed, arm.limits).ok
        guard = lt.Guard(arm, rate=rate)
        answer = guard.admit(timed[1:], timed.positions[0])
        assert answer.verdict == "allowed"
        assert np.array_equal(answer.motion.positions, timed.positions[1:])
        assert np.array_equal(answer.motion.velocities, timed.velocities[1:])
        part = timed[len(timed) // 3 : 2 * len(timed) // 3]
        assert lt.check_limits(lt.connect(HOMES[name], part, arm), arm.limits).ok
