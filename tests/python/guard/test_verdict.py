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


ALONG = np.array([1.2, 0.2, 0.0, 0.2, 0.0, 0.0, 0.3])


def gap_to(arm, rows, radius):
    """A ball beside the middle of a path, and how near the arm comes to it."""
    place = arm.forward_kinematics(rows[len(rows) // 2])[0] * [1.25, 1.25, 1.0]
    ball = lt.Sphere(radius, place)
    return ball, float(arm.distance(rows, [ball]).min())


@pytest.mark.parametrize("pace", [0.1, 0.5, 0.9])
def test_a_policy_of_any_pace_passes_an_obstacle_that_may_move(panda, pace):
    """It asks for a constant speed along a line from where the arm is, also from rest."""
    q, rate = HOMES["panda"], 100.0
    path = q + np.outer(np.linspace(0.0, 1.0, 200), ALONG)
    _, gap = gap_to(panda, path, 0.05)
    ball, gap = gap_to(panda, path, 0.05 + gap - 0.03)
    assert gap == pytest.approx(0.03, abs=1e-6)
    nearby = lt.shapes.MovingObstacle(ball, 0.5)
    guard = lt.Guard(panda, [nearby], rate=rate)
    guard.admit(q[None], q)
    step = pace * (panda.limits.velocity[ALONG > 0] / ALONG[ALONG > 0]).min() / rate
    sent, gone = [guard.state], 0.0
    for _ in range(700):
        gone = float((guard.state.q - q) @ ALONG / (ALONG @ ALONG))
        if gone > 0.999:
            break
        guard.update_obstacles([nearby])
        chunk = q + np.outer(np.clip(gone + step * np.arange(1, 51), 0.0, 1.0), ALONG)
        assert guard.admit(chunk).safe
        sent.append(guard.next())
    assert gone > 0.999
    sent.extend(guard.next() for _ in range(guard.remaining))
    assert lt.check_limits(motion_of(sent, rate, panda.joint_names), panda.limits).ok


@pytest.mark.parametrize(("gap", "passes"), [(0.00495, False), (0.00515, True)])
def test_a_margin_of_five_millimetres_means_five(panda, gap, passes):
    q, rate = HOMES["panda"], 50.0
    share = np.linspace(0.0, 1.0, 151)[1:]
    rows = q + np.outer(share**3 * (10.0 - 15.0 * share + 6.0 * share**2), ALONG)
    fine = q + np.outer(np.linspace(0.0, 1.0, 4001), ALONG)
    _, first = gap_to(panda, fine, 0.05)
    ball, nearest = gap_to(panda, fine, 0.05 + first - gap)
    assert nearest == pytest.approx(gap, abs=1e-6)
    guard = lt.Guard(panda, lt.Scene([ball], 0.005), rate=rate)
    answer = guard.admit(rows, q)
    assert (answer.verdict == "allowed") == passes
    assert panda.distance(answer.to_rest.positions, [ball]).min() >= 0.005 - 1e-6
