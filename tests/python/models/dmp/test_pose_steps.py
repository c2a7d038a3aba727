"""Steps of primitives of poses: goals that move, couplings, measured poses."""

import numpy as np
import pytest
from models.dmp.turns import (
    about_turning_axis,
    fitted,
    moved_goal,
    turn,
)

from leadthrough import rotations


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "log", "euler"])
def test_steps_lead_where_generate_does(orientation):
    u, q = turn(120, 100)
    skill = fitted(u, q, orientation=orientation)
    query = {"goal": ((0.4, 0.1, 0.2), moved_goal(q, 20)), "duration": 3.0}
    made = skill.generate(**query, dt=0.03)
    state = skill.begin(**query)
    for position, turned in zip(made.positions[1:], made.orientations[1:], strict=True):
        state = skill.step(state, 0.03)
        np.testing.assert_allclose(state.position, position, atol=1e-9)
        assert rotations.distance(state.orientation[None], turned[None])[0] < 1e-7


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "euler"])
def test_angular_velocity_is_the_derivative_of_the_orientation(orientation):
    u, q = about_turning_axis(150, 100)
    skill = fitted(u, q, orientation=orientation)
    state = skill.begin(start=((0, 0, 0), moved_goal(q[:1], 40)), duration=3.0)
    for _ in range(10):
        state = skill.step(state, 0.25)
        ahead = skill.step(state, 1e-5)
        step = rotations.compose(
            ahead.orientation[None], rotations.inverse(state.orientation[None])
        )
        np.testing.assert_allclose(rotations.log(step)[0] / 1e-5, state.angular_velocity, atol=2e-4)


def test_goal_that_moves_is_followed_and_changes_nothing_at_once():
    u, q = about_turning_axis(720, 100)
    skill = fitted(u, q)
    before = skill.step(skill.begin(), 2.0)
    goal = ((0.5, 0.0, 0.0), moved_goal(q, 90))
    after = skill.step(before, 1e-9, goal=goal)
    np.testing.assert_allclose(after.orientation, before.orientation, atol=1e-6)
    np.testing.assert_allclose(after.angular_velocity, before.angular_velocity, atol=1e-4)
    end = skill.step(after, 12.0)
    assert rotations.distance(end.orientation[None], goal[1][None])[0] < 1e-6
    np.testing.assert_allclose(end.position, goal[0], atol=1e-6)


def test_goal_that_turns_slowly_is_never_unwound():
    u, q = turn(90, 100)
    skill = fitted(u, q)
    state, turned = skill.begin(), 0.0
    for i in range(800):
        goal = rotations.compose(rotations.exp(np.radians([[0.0, 0.0, 0.6 * i]])), q[-1:])[0]
        after = skill.step(state, 0.01, goal=((0.3, 0.1, 0.2), goal))
        turned += rotations.distance(state.orientation[None], after.orientation[None])[0]
        state = after
    assert np.degrees(turned) < 800.0
    assert np.degrees(rotations.distance(state.orientation[None], goal[None]))[0] < 60.0


def test_measured_pose_is_where_the_motion_goes_on():
    u, q = about_turning_axis(720, 100)
    skill = fitted(u, q)
    state = skill.step(skill.begin(), 1.5)
    pushed = moved_goal(state.orientation[None], 25)
    after = skill.step(state, 1e-9, measured=(state.position + 0.05, pushed))
    assert rotations.distance(after.orientation[None], pushed[None])[0] < 1e-6
    np.testing.assert_allclose(after.position, state.position + 0.05, atol=1e-6)
    end = skill.step(after, 10.0)
    assert rotations.distance(end.orientation[None], q[-1:])[0] < 1e-6


def test_angular_coupling_turns_the_tool():
    u, q = turn(90, 100)
    skill = fitted(u, q)
    state = skill.step(skill.begin(), 1.0)
    pushed = skill.step(state, 1e-3, coupling=(0, 0, 0, 0, 0, 5.0))
    free = skill.step(state, 1e-3)
    gained = (pushed.angular_velocity - free.angular_velocity) / 1e-3
    np.testing.assert_allclose(gained, (0, 0, 5.0), atol=0.05)
    only_moved = skill.step(state, 1e-3, coupling=(1.0, 0.0, 0.0))
    np.testing.assert_allclose(only_moved.orientation, free.orientation, atol=1e-15)
