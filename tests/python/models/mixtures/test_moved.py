"""Mixtures with a moved start, goal or sample: bounded changes of the motion."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.models import Frame, TaskGMR, fit_mixture
from leadthrough.models.mixtures.phases import fit_phases, sampled
from leadthrough.models.mixtures.task_frames import shrunk

U = np.linspace(0.0, 1.0, 100)
KINDS = ("points", "joints", "poses")
# Demonstrations; of points also many.
COUNTS = (2, 3, 12)
MANY = {"points": (40,)}
# Times the way of the ends.
BOUND = 1.5
MODELS = {"GMR": lt.GMR(starts=1), "TaskGMR": TaskGMR(components=6, starts=1)}


def family(kind, count, *, share_goal=True, seed=0):
    """Motions of three harmonics with the goal, and its orientation, in common."""
    rng = np.random.default_rng(seed)
    common = 0.1 * rng.standard_normal((3, 3))
    waves = np.sin(np.pi * np.outer(U, [1.0, 2.0, 3.0]))
    shown = []
    for _ in range(count):
        points = np.outer(U, [0.4, 0.2, 0.1])
        points += waves @ (common + 0.01 * rng.standard_normal((3, 3)))
        points += np.outer(1.0 - U, 0.02 * rng.standard_normal(3))
        if not share_goal:
            points += np.outer(U, 0.02 * rng.standard_normal(3))
        shown.append(moving(kind, points, rng))
    return shown


def moving(kind, points, rng):
    if kind == "points":
        return lt.Trajectory(2.0 * U, points)
    if kind == "joints":
        more = points * [1.5, -0.5, 2.0] + np.outer(U * (1 - U), 0.2 * rng.standard_normal(3))
        return lt.JointTrajectory(2.0 * U, np.hstack([points, more]))
    begin = 0.2 * rng.standard_normal(3)
    turned = rotations.exp(np.outer(1.0 - U, begin) + np.outer(U, [0.2, 0.5, 1.0]))
    return lt.PoseTrajectory(2.0 * U, points, turned)


def place(motion, row, offset):
    moved = motion.positions[row] + offset
    return (moved, motion.orientations[row]) if isinstance(motion, lt.PoseTrajectory) else moved


def farthest(motion, usual):
    return float(np.linalg.norm(motion.positions - usual.positions, axis=1).max())


def moved_ends(skill, usual, *, size, rng):
    """Motions with the start, the goal or both moved by a distance, in random directions."""
    for names in (("start",), ("goal",), ("start", "goal")):
        query = {}
        for name in names:
            offset = rng.standard_normal(usual.positions.shape[1])
            offset *= size / np.linalg.norm(offset)
            query[name] = place(usual, 0 if name == "start" else -1, offset)
        yield skill.generate(**query, dt=0.02)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share_goal", [True, False])
def test_moved_ends_move_no_phase_by_more_than_the_bound(name, kind, share_goal):
    rng = np.random.default_rng(1)
    for count in (*COUNTS, *MANY.get(kind, ())):
        skill = MODELS[name].fit(family(kind, count, share_goal=share_goal))
        usual = skill.generate(dt=0.02)
        extent = float(np.linalg.norm(np.ptp(usual.positions, axis=0)))
        for size in (0.01 * extent, 0.3 * extent, 3.0 * extent):
            for made in moved_ends(skill, usual, size=size, rng=rng):
                assert farthest(made, usual) <= BOUND * size
                if kind == "poses":
                    angles = rotations.distance(made.orientations, usual.orientations)
                    assert angles.max() <= BOUND * size / (0.5 * extent)


@pytest.mark.parametrize("name", MODELS)
def test_a_turned_goal_moves_the_path_no_more_than_its_lever_does(name):
    rng = np.random.default_rng(2)
    for count in COUNTS:
        skill = MODELS[name].fit(family("poses", count))
        usual = skill.generate(dt=0.02)
        at, turned = usual.positions[-1], usual.orientations[[-1]]
        lever = float(np.linalg.norm(usual.positions - at, axis=1).max())
        for angle in (0.001, 0.03, 0.3, 1.0, 3.0):
            axis = rng.standard_normal(3)
            turn = rotations.exp(angle * axis[None] / np.linalg.norm(axis))
            asked = rotations.compose(turned, turn)[0]
            made = skill.generate(goal=(at, asked), dt=0.02)
            assert farthest(made, usual) <= BOUND * angle * lever
            off = rotations.distance(made.orientations, usual.orientations)
            assert off.max() <= BOUND * angle
            assert rotations.distance(made.orientations[-1:], asked[None])[0] < 1e-7


def test_a_situation_asked_for_by_frames_is_near_the_usual_one_too():
    """`at` gives a mixture, whose mean may be cut short nowhere: its weights are bounded."""
    for count in COUNTS:
        skill = TaskGMR(components=6, starts=1).fit(family("poses", count))
        usual = skill.generate(dt=0.02)
        start, goal = (Frame.of_sample(usual, row) for row in (0, -1))
        before = skill.at([start, goal]).generate(dt=0.02)
        turn = rotations.to_matrix(rotations.exp([[0.0006, -0.0006, 0.0005]]))[0]
        after = skill.at([start, Frame(goal.origin, turn @ goal.axes)]).generate(dt=0.02)
        assert farthest(after, before) <= 2.0 * 0.001 * 0.7


def test_mixtures_of_poses_follow_phases_and_not_single_demonstrations():
    """Units of the columns' own deviations took the mean motion 190 mm from the demonstrations'."""
    for share_goal in (True, False):
        motions = family("poses", 3, share_goal=share_goal)
        made = lt.GMR().fit(motions).generate(dt=0.02)
        at = np.linspace(0.0, 1.0, len(made.times))
        rows = [np.array([np.interp(at, U, c) for c in m.positions.T]).T for m in motions]
        assert np.linalg.norm(made.positions - np.mean(rows, axis=0), axis=1).max() < 0.06


def test_poses_of_thin_mixtures_in_earlier_files_still_learn_more():
    motions = family("poses", 6)
    old = lt.GMR(4).fit(motions[:3])
    thin = fit_mixture(sampled(motions[:3]).points, 4)  # as it was fitted before
    skill = replace(old, mixture=thin.mixture)
    more = skill.updated(motions[3:])
    assert more.demonstration_count == 6
    assert np.abs(more.mixture.means - skill.mixture.means).max() > 1e-3


@cache
def shown(kind, count, shared):
    return family(kind, count, share_goal=bool(shared), seed=1)


def test_a_fit_ends_at_its_own_likelihood_and_later_steps_only_add():
    """The bound of each later step is lower, so that no step of EM can lose likelihood."""
    for kind, poses in (("points", False), ("poses", True)):
        points = sampled(shown(kind, 3, 1)).points
        fit = fit_phases(points, 6, poses=poses, seed=0, starts=1)
        assert fit.log_likelihood == pytest.approx(fit.mixture.log_density(points).mean(), abs=1e-8)
        assert np.diff(fit.history).min() > -1e-10


def test_covariances_of_few_demonstrations_are_rounder_given_the_time():
    rng = np.random.default_rng(0)
    roots = rng.standard_normal((2, 7, 7))
    thin = roots @ roots.transpose(0, 2, 1)
    few, many = (shrunk(thin, count, poses=True) for count in (1, 1000))
    np.testing.assert_allclose(many, thin, rtol=0.05, atol=0.01)
    np.testing.assert_array_equal(few[:, 0], thin[:, 0])
    given_time = few[:, 1:, 1:] - few[:, 1:, :1] * few[:, :1, 1:] / few[:, :1, :1]
    for columns in (slice(0, 3), slice(3, 6)):
        part = given_time[:, columns, columns]
        np.testing.assert_allclose(part, part[:, :1, :1] * np.eye(3), atol=1e-9)
    np.testing.assert_allclose(
        np.trace(given_time[0]),
        np.trace(thin[0, 1:, 1:]) - (thin[0, 0, 1:] ** 2).sum() / thin[0, 0, 0],
    )
