"""The continuous logarithm: what it replays, and what it refuses beside whole turns."""

import numpy as np
import pytest
from models.dmp.turns import (
    DURATION,
    about_turning_axis,
    angle_turned,
    errors_of,
    fitted,
    moved_goal,
    noisy,
    peak_speed,
    turn,
    turned_by,
)

from leadthrough import rotations
from leadthrough.errors import FitError, UnsupportedQuery


@pytest.mark.parametrize("case", [turn(180, 1000), turn(200, 100), turn(720, 1000)])
def test_lifted_replays_turns_about_one_axis(case):
    assert errors_of(fitted(*case, orientation="lifted"), *case).max() < 0.3


def test_log_jumps_where_lifted_does_not():
    case = turn(200, 100)
    assert errors_of(fitted(*case, orientation="log"), *case).max() > 90.0


def test_lifted_refuses_what_it_cannot_follow():
    u, q = turn(350, 100)
    for case in (about_turning_axis(720, 100), (u, noisy(q, 0.05))):
        with pytest.raises(FitError, match="anchored"):
            fitted(*case, orientation="lifted")


@pytest.mark.parametrize("degrees", [170, 200, 350, 720])
@pytest.mark.parametrize("moved_by", [20, 90, 150])
def test_lifted_never_spins_silently(degrees, moved_by):
    u, q = turn(degrees, 100)
    skill = fitted(u, q, orientation="lifted")
    goal = ((0.3, 0.1, 0.2), moved_goal(q, moved_by))
    try:
        made = skill.generate(goal=goal)
    except UnsupportedQuery:
        assert degrees > 220
    else:
        assert abs(angle_turned(made.orientations) - degrees) <= moved_by + 21.0


def random_turn(rng):
    """Phases, orientations, and how far they turn: 20 to 700 degrees, about one axis or several."""
    degrees, rate = rng.uniform(20.0, 700.0), int(rng.choice([50, 100, 200]))
    u, q = (turn if rng.random() < 0.5 else about_turning_axis)(degrees, rate)
    return u, q, degrees


def random_pose(rng, q, position):
    """A pose turned from q (4,) by up to 179 degrees about any axis, and that angle."""
    moved_by, axis = rng.uniform(0.0, 179.0), rng.normal(size=3)
    return (position, turned_by(q, moved_by, axis / np.linalg.norm(axis))), moved_by


def assert_no_spin(made, degrees, moved_by):
    """That a motion turns as far as was shown, and no quicker than all its turns together."""
    assert abs(angle_turned(made.orientations) - degrees) <= moved_by + 25.0
    assert peak_speed(made) <= 2.0 * np.radians(1.875 * (degrees + moved_by) / DURATION)


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.3])
def test_lifted_is_refused_or_does_not_spin_in_random_cases(noise):
    refused = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        u, q, degrees = random_turn(rng)
        noisy = rotations.compose(q, rotations.exp(rng.normal(0, np.radians(noise), (len(q), 3))))
        start, back = random_pose(rng, q[0], (0.0, 0.0, 0.0))
        goal, forth = random_pose(rng, q[-1], (0.3, 0.1, 0.2))
        try:
            skill = fitted(u, noisy, orientation="lifted")
            assert errors_of(skill, u, q).max() < 25.0
            assert_no_spin(skill.generate(goal=goal, dt=0.005), degrees, forth)
            assert_no_spin(skill.generate(start=start, goal=goal, dt=0.005), degrees, back + forth)
        except (FitError, UnsupportedQuery) as error:
            assert "anchored" in str(error)
            refused += degrees < 180.0
    assert refused <= 3  # of those below half a turn


def test_lifted_is_refused_or_does_not_spin_where_its_goal_moves_on_the_way():
    followed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        degrees = rng.uniform(20.0, 700.0)
        u, q = turn(degrees, 100)
        skill = fitted(u, q, orientation="lifted")
        goal, moved_by = random_pose(rng, q[-1], (0.3, 0.1, 0.2))
        state, rows = skill.step(skill.begin(), rng.uniform(0.2, 3.0)), []
        try:
            state = skill.step(state, 1e-6, goal=goal)
        except UnsupportedQuery as error:
            assert "anchored" in str(error)
            continue
        while state.phase < 1.0:
            rows.append(state.orientation)
            state = skill.step(state, 0.01)
        assert angle_turned(np.array(rows)) <= degrees + moved_by + 25.0
        followed += 1
    assert followed > 20


def test_noise_of_the_samples_is_no_turn_that_lifted_lacks():
    u, q = turn(120, 600)
    noise = np.random.default_rng(0).normal(0.0, np.radians(0.1), (len(u), 3))
    noisy = rotations.compose(q, rotations.exp(noise))
    assert angle_turned(noisy) > 180
    made = fitted(u, noisy, orientation="lifted").generate()
    assert angle_turned(made.orientations) == pytest.approx(120, abs=2)
