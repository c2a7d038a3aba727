"""Mixtures of phases: one sample that changes by a millimetre hardly moves the motion."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from models.mixtures.test_moved import MODELS, family, farthest

import leadthrough as lt
from leadthrough.models import TaskGMR
from leadthrough.models.mixtures.phases import fit_phases, sampled
from leadthrough.models.mixtures.task_frames import shrunk

# Families of which another maximum of the likelihood moved motions by up to 303 mm (rad / 1000).
FAMILIES = [("points", 2, 0), ("points", 3, 1), ("joints", 2, 1), ("joints", 5, 0), ("poses", 3, 1)]
ROWS = (0, 50, 99)
# A few tenths are the change itself, of the mean of two or three demonstrations.
MOST = {"GMR": 1e-3, "TaskGMR": 2e-3}


@cache
def shown(kind, count, shared):
    return [each.motion for each in family(kind, count, share_goal=bool(shared), seed=1)]


def most_moved(model, motions, rows):
    """How far the motion moves where one sample of the first demonstration moves by 1 mm."""
    goal = motions[0].positions[-1].copy()
    goal[:3] += [0.05, -0.05, 0.02]
    place = (goal, motions[0].orientations[-1]) if hasattr(motions[0], "orientations") else goal

    def made(first):
        return model.fit([first, *motions[1:]]).generate(goal=place, dt=0.02)

    usual, moves = made(motions[0]), []
    for row in rows:
        positions = motions[0].positions.copy()
        positions[row, 0] += 0.001
        moves.append(farthest(made(replace(motions[0], positions=positions)), usual))
    return max(moves)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("case", FAMILIES, ids=str)
def test_a_millimetre_in_one_sample_moves_motions_by_a_few_at_most(name, case):
    assert most_moved(MODELS[name], shown(*case), ROWS) <= MOST[name]


@pytest.mark.parametrize("model", [lt.GMR(), TaskGMR()], ids=["GMR", "TaskGMR"])
@pytest.mark.parametrize("case", FAMILIES[1:4:2], ids=str)
def test_the_best_of_several_starts_is_as_steady(model, case):
    assert most_moved(model, shown(*case), ROWS[1:2]) <= MOST[type(model).__name__]


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
