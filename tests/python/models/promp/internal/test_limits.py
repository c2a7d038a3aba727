"""ProMPs inside limits."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models.promp.limits import checked, moved_inside


def test_limits_hold_for_mean_and_samples_and_via_points_stay(skill):
    upper = [0.8, 1.9, np.inf]
    limited = skill.condition(1.0, [0.5, 1.0, 1.4]).within([-0.2, -np.inf, -np.inf], upper)
    for motion in (limited.generate(), *limited.sample(5, seed=0)):
        assert (motion.positions <= np.array(upper) + 1e-6).all()
        assert (motion.positions[:, 0] >= -0.2 - 1e-6).all()
    np.testing.assert_allclose(limited.distribution([1.0])[0][0], [0.5, 1.0, 1.4], atol=1e-6)
    moved = limited.condition(0.4, [0.6, 0.5, 0.4])
    assert (moved.generate().positions <= np.array(upper) + 1e-6).all()


def test_limits_that_nothing_touches_change_nothing(skill):
    limited = skill.within([-100.0] * 3, [100.0] * 3)
    np.testing.assert_array_equal(limited.weights.mean, skill.weights.mean)


def test_limits_that_a_via_point_breaks_are_refused(skill):
    fixed = skill.condition(1.0, [0.5, 1.0, 1.4])
    with pytest.raises(InvalidInput, match="limits"):
        fixed.within([-1.0] * 3, [0.4, 9.0, 9.0])


def test_moved_inside_is_the_nearest_in_the_covariances_measure(shown):
    skill = lt.ProMP(weights=8).fit(shown())
    bounds = checked([-9.0] * 3, [0.9, 9.0, 9.0], 3)
    moved = moved_inside(skill.weights, skill.basis, bounds, skill.scale)
    step = moved - skill.weights.mean
    cost = step @ np.linalg.solve(skill.weights.covariance, step)
    rng = np.random.default_rng(0)
    rows = np.kron([1.0, 0.0, 0.0], skill.basis(np.linspace(0, 1, 81)))
    for _ in range(200):
        other = moved + 0.02 * skill.weights.root @ rng.standard_normal(24)
        if (rows @ other <= (rows @ moved).max()).all():
            away = other - skill.weights.mean
            assert away @ np.linalg.solve(skill.weights.covariance, away) >= cost - 1e-6
