"""How far a moved start or goal, another pace or one wrong sample may change a motion."""

import numpy as np
import pytest
from models.marching.paths import apart, size_of
from motions import minimum_jerk

import leadthrough as lt

OFFSETS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # of the demonstrations' size
DIRECTIONS = np.deg2rad([20.0, 140.0, 260.0])
SHARE = np.linspace(0.0, 1.0, 120)
RISE = minimum_jerk(SHARE)


def family(seed, count, *, closed=False, slower=1.0):
    """Curves of one kind in the plane, with scattered ends; closed ones return to their start."""
    rng = np.random.default_rng(seed)
    bends, ends = rng.normal(0.0, 0.15, (4, 2)), rng.normal(0.0, 0.3, (2, 2))
    waves = np.stack([np.sin(np.pi * (k + 1) * RISE) for k in range(4)], axis=1)
    made = []
    for _ in range(count):
        own, (first, last) = (
            values + rng.normal(0.0, 0.02, values.shape) for values in (bends, ends)
        )
        last = first + rng.normal(0.0, 0.01, 2) if closed else last
        points = first + np.outer(RISE, last - first) + waves @ own
        made.append(lt.Trajectory(slower * (1.5 + 0.2 * rng.random()) * SHARE, points))
    return made


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("count", [2, 5, 40])
@pytest.mark.parametrize("seed", [0, 1])
def test_moved_ends_move_the_motion_in_proportion(seed, count, closed):
    skill = lt.FastMarching().fit(family(seed, count, closed=closed))
    usual, query, size = skill.plan(), skill.query(), size_of(skill)
    for index, offset in enumerate(OFFSETS):
        angle = DIRECTIONS[index % 3]
        move = offset * size * np.array([np.cos(angle), np.sin(angle)])
        for start, goal in ((move, 0.0), (0.0, move), (move, move)):
            found = skill.plan(start=query.start + start, goal=query.goal + goal)
            if found.method == usual.method:
                bound = 1.5 * offset * size + skill.area_of_influence
                assert apart(usual.path, found.path) <= bound
                continue
            region = np.concatenate([*skill.experience, found.path[[0, -1]]])
            beyond = np.maximum(region.min(axis=0) - found.path, found.path - region.max(axis=0))
            assert beyond.max() <= offset * size


def test_ends_moved_past_each_other_do_not_turn_the_motion_around():
    """Reversed demonstrations, whose ends fitted better, moved the motion by 2.06 times as much."""
    skill = lt.FastMarching().fit(family(6, 40))
    usual, query, size = skill.plan(), skill.query(), size_of(skill)
    for angle in np.deg2rad(np.arange(0.0, 360.0, 30.0)):
        move = 0.3 * size * np.array([np.cos(angle), np.sin(angle)])
        found = skill.plan(start=query.start + move, goal=query.goal - move)
        if found.method == usual.method:
            bound = 1.5 * 0.3 * size + skill.area_of_influence
            assert apart(usual.path, found.path) <= bound


def test_moved_poses_turn_no_farther_than_their_ends():
    flat = [each.positions for each in family(3, 5)]
    shown = [
        lt.PoseTrajectory(
            2.0 * SHARE,
            np.column_stack([path, 0.1 * RISE]),
            lt.rotations.exp(np.outer(RISE, [0.2, 0.1, 1.2]) + 0.02 * index),
        )
        for index, path in enumerate(flat)
    ]
    skill = lt.FastMarching().fit(shown)
    usual = skill.generate()
    for angle in (0.01, 0.3, 1.0):
        turn = lt.rotations.exp([[0.0, angle, 0.0]])
        ends = lt.rotations.compose(turn, usual.orientations[-1:])[0]
        made = skill.generate(goal=(usual.positions[-1], ends))
        assert np.allclose(made.positions, usual.positions)
        off = lt.rotations.distance(made.orientations, usual.orientations)
        assert off.max() <= 1.5 * angle
