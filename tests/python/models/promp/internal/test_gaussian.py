"""Normal and posterior predictive distributions of weights, and limits on them."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.models.promp import gaussian
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.combination import product
from leadthrough.models.promp.estimation import PosteriorPredictive
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.inference import Seen
from leadthrough.models.promp.limits import checked, moved_inside


def test_product_of_gaussians_is_that_of_their_densities():
    rng = np.random.default_rng(3)
    roots = rng.standard_normal((2, 3, 3))
    a, b = (Gaussian(rng.standard_normal(3), root @ root.T) for root in roots)
    both = product([a, b], [1.0, 2.0])
    precision = np.linalg.inv(a.covariance) + 2.0 * np.linalg.inv(b.covariance)
    np.testing.assert_allclose(np.linalg.inv(both.covariance), precision, rtol=1e-6, atol=1e-6)
    pull = np.linalg.solve(a.covariance, a.mean) + 2.0 * np.linalg.solve(b.covariance, b.mean)
    np.testing.assert_allclose(both.mean, np.linalg.solve(precision, pull), atol=1e-8)


@pytest.mark.parametrize("rank", [1, 5, 12])
def test_roots_square_to_the_covariance_and_draw_nothing_where_it_is_zero(rank):
    rng = np.random.default_rng(rank)
    wide = rng.standard_normal((12, rank))
    covariance = wide @ wide.T
    root = Gaussian(np.zeros(12), covariance).steady_root
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)
    assert np.linalg.matrix_rank(root) == rank
    drawn = Gaussian(np.zeros(12), covariance).draw(4000, rng)
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=0.08 * np.trace(covariance))
    fixed = np.linalg.svd(wide)[0][:, rank:]
    np.testing.assert_allclose(drawn @ fixed, 0.0, atol=1e-7)


def test_determinants_and_inverses_agree_with_numpys():
    rng = np.random.default_rng(4)
    wide = rng.standard_normal((9, 9))
    matrix = wide @ wide.T + np.eye(9)
    assert gaussian.log_determinant(matrix) == pytest.approx(np.linalg.slogdet(matrix)[1])
    np.testing.assert_allclose(gaussian.inverse_definite(matrix), np.linalg.inv(matrix), atol=1e-12)
    with pytest.raises(np.linalg.LinAlgError):
        gaussian.log_determinant(-matrix)
    stiff = np.eye(9) + 1e12 * np.outer(wide[0], wide[0])
    wanted = np.log1p(1e12 * (wide[0] ** 2).sum())
    assert gaussian.log_determinant(stiff, least=1.0) == pytest.approx(wanted, abs=0.01)


def test_row_basis_spans_the_rows_and_is_orthonormal_where_they_nearly_agree():
    rng = np.random.default_rng(3)
    lengths = np.diag([1.0, 1e-3, 1e-6, 1e-12])
    rows = rng.standard_normal((30, 4)) @ lengths @ rng.standard_normal((4, 50))
    basis, chosen = gaussian.row_basis(rows, least=1e-9)
    assert basis.shape == (3, 50)
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(rows @ basis.T @ basis, rows, atol=1e-10)
    triangle = rows[chosen] @ basis.T
    assert np.abs(np.triu(triangle, 1)).max() < 1e-14


def test_a_forecast_is_the_posterior_of_a_t_distribution():
    rng = np.random.default_rng(0)
    basis, noise, freedom = Basis("gaussian", 6), np.array([0.01]), 6.0
    root = rng.normal(size=(6, 6))
    predictive = PosteriorPredictive(Gaussian(rng.normal(size=6), root @ root.T), freedom)
    phases = np.linspace(0.0, 0.5, 7)
    rows = basis(phases)
    values = (rows @ (predictive.spread.mean + root @ rng.normal(size=6)))[:, None]
    # By importance sampling from the prior, over the factor alone.
    factors = 0.5 * freedom / rng.gamma(0.5 * freedom, size=20_000)
    missed = (values - rows @ predictive.spread.mean[:, None])[:, 0]
    scores, means = [], []
    for factor in factors:
        spread = factor * rows @ predictive.spread.covariance @ rows.T + 0.01 * np.eye(7)
        solved = np.linalg.solve(spread, missed)
        scores.append(-0.5 * (missed @ solved + np.linalg.slogdet(2.0 * np.pi * spread)[1]))
        means.append(factor * predictive.spread.covariance @ rows.T @ solved)
    likely = np.exp(scores)
    seen = Seen(predictive, basis, phases, values, noise)
    assert seen.evidence == pytest.approx(np.log(likely.mean()), abs=0.02)
    expected = predictive.spread.mean + likely @ np.array(means) / likely.sum()
    np.testing.assert_allclose(seen.forecast().weights.mean, expected, atol=0.02)


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
    refused("limits", fixed.within, [-1.0] * 3, [0.4, 9.0, 9.0])


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
