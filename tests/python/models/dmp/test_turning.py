"""Starts, goals and frames that are turned from what was shown."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from models.dmp.turns import (
    DURATION,
    FIXED,
    HARD,
    HARD_AT_50_HZ,
    WAVE,
    about_turning_axis,
    across,
    angle_turned,
    demonstration,
    fitted,
    moved_goal,
    noisy,
    peak_speed,
    positions,
    turn,
    turned_by,
)

import leadthrough as lt
from leadthrough import rotations


@pytest.mark.parametrize(("moved_by", "quicker"), [(20, 1.15), (90, 1.3)])
@pytest.mark.parametrize(
    "case", [*HARD.values(), *HARD_AT_50_HZ.values()], ids=[*HARD, *HARD_AT_50_HZ]
)
def test_goal_turned_off_the_axis_is_reached_without_a_spin(case, moved_by, quicker):
    u, q = case
    skill, shown = fitted(u, q), demonstration(u, q).motion
    for axis in across(FIXED, 12):
        goal = turned_by(q[-1], moved_by, axis)
        made = skill.generate(goal=((0.5, 0.0, 0.3), goal), dt=0.004)
        assert np.degrees(rotations.distance(made.orientations[-1:], goal[None]))[0] < 1e-6
        np.testing.assert_allclose(made.positions[-1], (0.5, 0.0, 0.3), atol=1e-9)
        assert angle_turned(made.orientations) <= 1.02 * angle_turned(q) + moved_by
        assert peak_speed(made) <= quicker * peak_speed(shown)


@pytest.mark.parametrize(("moved_by", "quicker"), [(20, 1.15), (90, 1.3)])
def test_goal_of_a_noisy_motion_is_reached_without_a_spin(moved_by, quicker):
    u, q = turn(350, 100)
    skill, shown = fitted(u, noisy(q, 0.05)), demonstration(u, q).motion
    for axis in across(FIXED, 12):
        goal = turned_by(q[-1], moved_by, axis)
        made = skill.generate(goal=((0.5, 0.0, 0.3), goal), dt=0.004)
        assert np.degrees(rotations.distance(made.orientations[-1:], goal[None]))[0] < 1e-6
        assert angle_turned(made.orientations) <= 1.02 * 350 + moved_by
        assert peak_speed(made) <= quicker * peak_speed(shown)


@given(st.integers(0, 2**32 - 1), st.floats(1.0, 179.0), st.sampled_from([90, 200, 720]))
def test_speeds_of_a_motion_and_of_its_goal_add_up(seed, moved_by, degrees):
    """About any axis: at worst, along that of the motion, both peak together."""
    u, q = turn(degrees, 100)
    axis = np.random.default_rng(seed).normal(size=3)
    goal = turned_by(q[-1], moved_by, axis / np.linalg.norm(axis))
    made = fitted(u, q).generate(goal=((0.3, 0.1, 0.2), goal))
    assert angle_turned(made.orientations) <= 1.001 * degrees + moved_by
    together = np.radians(1.875 * (degrees + moved_by) / DURATION)
    assert peak_speed(made) <= 1.001 * together


@pytest.mark.parametrize("degrees", [170, 350, 720])
def test_start_turned_off_the_axis_is_left_without_a_spin(degrees):
    u, q = turn(degrees, 100)
    start = moved_goal(q[:1], 60)
    made = fitted(u, q).generate(start=((0.0, 0.1, 0.0), start))
    np.testing.assert_allclose(
        rotations.distance(made.orientations[[0]], start[None]), 0, atol=1e-9
    )
    np.testing.assert_allclose(rotations.distance(made.orientations[[-1]], q[-1:]), 0, atol=1e-9)
    assert angle_turned(made.orientations) <= 1.02 * degrees + 60


def unit_quaternions(seed, count=1):
    q = np.random.default_rng(seed).normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1)[:, None]


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 20.0))
def test_any_pose_is_reached_from_any_pose(seed, duration):
    start, goal = unit_quaternions(seed, 2)
    made = WAVE.generate(
        start=((1.0, 0.0, 0.0), start), goal=((0.0, 1.0, 0.0), goal), duration=duration, dt=0.1
    )
    ends = rotations.distance(made.orientations[[0, -1]], np.array([start, goal]))
    np.testing.assert_allclose(ends, 0.0, atol=1e-7)
    np.testing.assert_allclose(made.positions[[0, -1]], [(1, 0, 0), (0, 1, 0)], atol=1e-9)
    assert made.duration == pytest.approx(duration)


@given(st.integers(0, 2**32 - 1))
def test_frame_does_not_matter(seed):
    frame = unit_quaternions(seed)
    u, q = about_turning_axis(720, 50)
    turned = rotations.compose(np.repeat(frame, len(q), axis=0), q)
    goal = moved_goal(q, 30)
    here = fitted(u, q, weights=15).generate(goal=(positions(u)[-1], goal))
    there = fitted(u, turned, weights=15).generate(
        goal=(positions(u)[-1], rotations.compose(frame, goal[None])[0])
    )
    expected = rotations.compose(np.repeat(frame, len(here.times), axis=0), here.orientations)
    assert rotations.distance(there.orientations, expected).max() < 1e-7


@given(st.integers(0, 2**32 - 1))
def test_motion_turned_as_a_whole_is_the_motion_in_another_frame(seed):
    """Also by half a turn, whose axis a rule chooses: start and goal choose the same."""
    frame = unit_quaternions(seed)
    if seed % 2:
        frame[0, 0] = 0.0
        frame /= np.linalg.norm(frame)
    plain = WAVE.generate()
    ends = rotations.compose(np.repeat(frame, 2, axis=0), plain.orientations[[0, -1]])
    made = WAVE.generate(start=(plain.positions[0], ends[0]), goal=(plain.positions[-1], -ends[1]))
    expected = rotations.compose(np.repeat(frame, len(plain.times), axis=0), plain.orientations)
    assert rotations.distance(made.orientations, expected).max() < 1e-7


def test_signs_of_quaternions_do_not_matter():
    u, q = about_turning_axis(720, 100)
    flips = np.where(np.random.default_rng(2).random(len(q)) < 0.5, -1.0, 1.0)[:, None]
    raw = demonstration(u, flips * q)
    made = lt.DMP().fit([raw]).generate(goal=((0.3, 0.1, 0.2), -q[-1]))
    expected = fitted(u, q).generate(goal=((0.3, 0.1, 0.2), q[-1]))
    assert rotations.distance(made.orientations, expected.orientations).max() < 1e-12
