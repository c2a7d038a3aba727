"""ProMPs inside limits: their distribution is that of the motions that keep the limits."""

import numpy as np
import pytest
from scipy.stats import truncnorm

from leadthrough import _core

INF = np.inf
LIMITS = {
    "one joint from above": ([-INF] * 3, [1.0, INF, INF]),
    "two joints": ([-0.05, -INF, -INF], [1.0, 2.0, INF]),
    "all joints from both sides": ([-0.2] * 3, [1.0, 1.9, 3.1]),
}
TIMES = np.linspace(0.0, 2.0, 41)


def kept(skill, lower, upper, least=5000):
    """Values (n, m, d) of motions drawn without limits, of which those that keep them are taken."""
    rng = np.random.default_rng(1)
    phases = np.linspace(0.0, 1.0, 81)
    rows = skill.basis(phases)
    inside = []
    while sum(map(len, inside)) < least:
        normal = rng.standard_normal((10_000, len(skill.free.mean)))
        weights = skill.free.mean + normal @ skill.free.root.T
        values = np.matmul(rows, weights.reshape(len(weights), skill.coordinates.width, -1).mT)
        inside.append(values[((values >= lower) & (values <= upper)).all(axis=(1, 2)), ::2])
    return np.concatenate(inside)


@pytest.mark.parametrize("limits", LIMITS.values(), ids=LIMITS)
def test_mean_covariance_and_samples_are_those_of_motions_that_keep_the_limits(skill, limits):
    limited = skill.within(*limits)
    truth = kept(skill, *limits)
    spread = truth.std(axis=0)
    mean, covariance = limited.distribution(TIMES)
    assert (np.abs(mean - truth.mean(axis=0)) / spread).max() < 0.05
    deviations = np.sqrt(np.einsum("nii->ni", covariance)) / spread
    assert np.abs(deviations - 1.0).max() < 0.06
    np.testing.assert_allclose(limited.generate(dt=0.05).positions, mean, atol=1e-12)
    weights = limited.sample_weights(2000, seed=2).reshape(2000, 3, -1)
    drawn = np.matmul(skill.basis(TIMES / 2.0), weights.mT)
    assert (np.abs(drawn.mean(axis=0) - mean) / spread).max() < 0.1
    assert np.abs(drawn.std(axis=0) / spread - 1.0).max() < 0.1
    for values in (mean, drawn):
        assert (values >= limits[0]).all()
        assert (values <= limits[1]).all()


def test_one_wall_gives_the_truncated_normal_distribution():
    rng = np.random.default_rng(0)
    velocities = rng.standard_normal((100_000, 3))
    for limit in (-1.5, 0.0, 2.0):
        wall = np.array([[0.6, 0.0, 0.8]])
        start = (limit - 0.1) * wall[0]
        along = (
            _core.sample_truncated_gaussian(wall, np.array([limit]), start, velocities) @ wall[0]
        )
        exact = truncnorm(-INF, limit)
        assert along.max() <= limit + 1e-12
        assert along.mean() == pytest.approx(exact.mean(), abs=0.02)
        assert along.std() == pytest.approx(exact.std(), rel=0.02)


def test_limits_far_below_the_mean_are_kept_too(skill):
    """No motion of the eight shown keeps them, nor would one in a million that are drawn."""
    limited = skill.within([-INF] * 3, [0.4, INF, INF])
    mean, covariance = limited.distribution(TIMES)
    assert (mean[:, 0] <= 0.4).all()
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    assert (covariance[:, 0, 0] < 1.01 * skill.distribution(TIMES)[1][:, 0, 0]).all()
    for motion in limited.sample(5, seed=0):
        assert (motion.positions[:, 0] <= 0.4 + 1e-9).all()


def test_what_is_observed_first_does_not_matter(skill):
    upper = [0.9, 1.9, INF]
    first = skill.within([-INF] * 3, upper).condition(1.0, [0.5, 1.0, 1.4])
    then = skill.condition(1.0, [0.5, 1.0, 1.4]).within([-INF] * 3, upper)
    np.testing.assert_array_equal(first.weights.mean, then.weights.mean)
    np.testing.assert_array_equal(first.weights.covariance, then.weights.covariance)


def test_a_start_asked_for_is_met_inside_the_limits(skill):
    limited = skill.within([-INF] * 3, [0.9, 1.9, INF])
    start = skill.generate().positions[0] + 0.02
    moved = limited.generate(start=start).positions
    np.testing.assert_allclose(moved[0], start, atol=1e-9)
    assert (moved <= [0.9, 1.9, INF]).all()
