"""Easing onto a motion from where the arm is, and off it to rest."""

import numpy as np
import pytest
from guard.adversary import HOMES
from guard.judge import EXCESS, worst_use
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput, LimitsInfeasible, NoPath
from leadthrough.guard import CommandedState

Q = HOMES["panda"]
RATE = 100.0
TIMES = np.arange(0, 100) / RATE
MOVING = Q + 0.2 * np.outer(np.sin(2.0 * TIMES + 0.3), np.linspace(1.0, 0.2, 7))


def motion_of(rows, **more):
    return lt.JointTrajectory(TIMES[: len(rows)], rows, **more)


def test_a_motion_cut_out_of_another_begins_and_ends_at_rest(panda):
    whole = lt.connect(Q - 0.1, motion_of(MOVING), panda)
    assert np.array_equal(whole.positions[0], Q - 0.1)
    assert worst_use(whole.positions, panda.limits, RATE) <= 1.0 + EXCESS
    assert lt.check_limits(whole, panda.limits, linear_rate=RATE).ok
    begin = int(np.abs(whole.positions - MOVING[0]).max(axis=1).argmin())
    assert np.array_equal(whole.positions[begin : begin + 100], MOVING)
    assert not np.diff(whole.positions[-2:], axis=0).round(12).any()


def test_two_samples_are_joined_as_if_the_motion_rested_after_them(panda):
    first, second = Q + 0.1, Q + 0.1005
    two = lt.connect(Q, motion_of([first, second]), panda).positions
    resting = lt.connect(Q, motion_of([first, second, second]), panda).positions
    end = 2 + int(np.abs(resting - first).max(axis=1).argmin())
    assert np.array_equal(two[:end], resting[:end])


def test_a_moving_arm_is_taken_along(panda):
    state = CommandedState(Q, np.full(7, 0.4), np.zeros(7))
    whole = lt.connect(state, motion_of(MOVING), panda)
    before = np.array([Q - 0.8 / RATE, Q - 0.4 / RATE])
    rows = np.concatenate([before, whole.positions])
    for order, limit in ((2, panda.limits.acceleration), (3, panda.limits.jerk)):
        used = np.abs(np.diff(rows, order, axis=0)) * RATE**order / limit
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


def test_wrong_arguments_are_named(panda):
    refused("trajectory: expected a JointTrajectory", lt.connect, Q, MOVING, panda)
    with pytest.raises(InvalidInput, match="trajectory: expected at least two samples"):
        lt.connect(Q, motion_of(MOVING[:1]), panda)
    refused("state: expected shape", lt.connect, Q[:2], motion_of(MOVING), panda)
