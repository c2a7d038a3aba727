"""The mean path of demonstrations, and the route along it, with one wrong sample."""

import numpy as np
import pytest
from models.marching.paths import apart
from models.marching.test_moved_ends import family

import leadthrough as lt
from leadthrough.models.marching import mean_path


@pytest.mark.parametrize("sample", [0, 36, 60, 119])
def test_one_sample_off_by_a_millimetre_changes_the_path_by_little_more(sample):
    for seed in range(4):
        shown = family(seed, 5)
        points = shown[0].positions.copy()
        points[sample] += (0.001, 0.0)
        changed = [lt.Trajectory(shown[0].times, points), *shown[1:]]
        skills = [lt.FastMarching().fit(motions) for motions in (shown, changed)]
        means = [_mean(skill) for skill in skills]
        assert np.linalg.norm(means[0] - means[1], axis=1).max() < 0.001
        assert apart(*(skill.plan().path for skill in skills)) < 0.0015


def _mean(skill):
    """The predicted path between the nominal ends."""
    query = skill.query()
    return next(mean_path.branches(skill.demonstrated, query.start, query.goal)).path
