"""Gaussian mixtures, by EM, and k-means."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import raised, refused
from scipy.stats import multivariate_normal

import leadthrough as lt
from leadthrough.errors import FitError
from leadthrough.models import Mixture, choose_components, fit_mixture, kmeans, trace_mixture


def random_mixture(count=3, size=4, seed=0):
    rng = np.random.default_rng(seed)
    roots = rng.standard_normal((count, size, size)) / 2
    weights = rng.random(count) + 0.2
    return Mixture(
        weights / weights.sum(),
        2.0 * rng.standard_normal((count, size)),
        roots @ roots.transpose(0, 2, 1) + 0.05 * np.eye(size),
    )


def test_density_is_the_weighted_sum_of_normal_ones():
    mixture = random_mixture()
    points = mixture.sample(50, seed=1)
    parts = [
        weight * multivariate_normal(mean, covariance).pdf(points)
        for weight, mean, covariance in zip(
            mixture.weights, mixture.means, mixture.covariances, strict=True
        )
    ]
    np.testing.assert_allclose(mixture.log_density(points), np.log(np.sum(parts, axis=0)))
    np.testing.assert_allclose(
        mixture.responsibilities(points).T, parts / np.sum(parts, axis=0), atol=1e-12
    )


@pytest.mark.parametrize(("inputs", "outputs"), [([0], [1, 2, 3]), ([2, 0], [3, 1])])
def test_regression_equals_monte_carlo(inputs, outputs):
    """Outputs drawn from the components' conditional distributions, by their weight there."""
    mixture = random_mixture()
    x = mixture.means[:2, inputs] * 0.7
    mean, covariance = mixture.regress(x, inputs=inputs, outputs=outputs)
    rng = np.random.default_rng(0)
    # An independent form: conditionals written with the precision matrix.
    for i in range(len(x)):
        draws = []
        weights = [
            w * multivariate_normal(m[inputs], c[np.ix_(inputs, inputs)]).pdf(x[i])
            for w, m, c in zip(mixture.weights, mixture.means, mixture.covariances, strict=True)
        ]
        counts = rng.multinomial(400_000, weights / np.sum(weights))
        for count, m, c in zip(counts, mixture.means, mixture.covariances, strict=True):
            precision = np.linalg.inv(c[np.ix_(inputs + outputs, inputs + outputs)])
            a, b = len(inputs), len(inputs + outputs)
            inner = np.linalg.inv(precision[a:b, a:b])
            middle = m[outputs] - inner @ precision[a:b, :a] @ (x[i] - m[inputs])
            draws.append(rng.multivariate_normal(middle, inner, count))
        values = np.concatenate(draws)
        scale = np.abs(covariance[i]).max()
        np.testing.assert_allclose(mean[i], values.mean(axis=0), atol=0.02 * np.sqrt(scale))
        np.testing.assert_allclose(covariance[i], np.cov(values.T), atol=0.02 * scale)


def test_spread_of_the_components_is_part_of_the_covariance():
    """Two branches: the printed form of the covariance would miss the distance between them."""
    branches = Mixture([0.5, 0.5], [[0, 1], [0, -1]], np.tile(np.diag([1.0, 0.01]), (2, 1, 1)))
    mean, covariance = branches.regress([[0.3]], inputs=[0])
    assert mean[0, 0] == pytest.approx(0.0)
    assert covariance[0, 0, 0] == pytest.approx(1.01)


def test_far_inputs_take_the_nearest_component_and_stay_finite():
    mixture = random_mixture()
    mean, covariance = mixture.regress([[1e4], [-1e4]], inputs=[0])
    assert np.isfinite(mean).all()
    assert np.isfinite(covariance).all()


def test_fit_history_ends_at_the_mixtures_own_likelihood():
    points = 1e3 * random_mixture(3, 2, seed=4).sample(500, seed=5)
    fit = fit_mixture(points, 3)
    assert fit.log_likelihood == pytest.approx(fit.mixture.log_density(points).mean(), abs=1e-8)
    assert np.diff(fit.history).min() > -1e-12
    assert fit_mixture(points, 3).mixture.means.tobytes() == fit.mixture.means.tobytes()


def test_likelihood_never_falls_where_variances_are_as_small_as_they_may_be():
    t = np.repeat(np.linspace(0.0, 1.0, 100), 2)
    fit = fit_mixture(np.column_stack([t, 2.0 * t, np.ones(200)]), 4)
    assert np.diff(fit.history).min() > -1e-8
    assert (np.linalg.eigvalsh(fit.mixture.covariances) > 0.0).all()


@pytest.mark.parametrize(("count", "size", "seed"), [(5, 3, 1), (8, 2, 3)])
def test_fit_is_as_likely_as_the_best_of_five_of_scikit_learn(count, size, seed):
    sklearn_mixture = pytest.importorskip("sklearn.mixture")
    points = random_mixture(count, size, seed).sample(400, seed=seed)
    peer = sklearn_mixture.GaussianMixture(
        count, n_init=5, max_iter=500, tol=1e-5, random_state=seed
    ).fit(points)
    assert fit_mixture(points, count).log_likelihood >= peer.score(points) - 0.01


@pytest.mark.parametrize("name", ["Angle", "CShape", "JShape"])
def test_handwriting_is_as_likely_as_with_the_best_of_five_of_scikit_learn(name):
    sklearn_mixture = pytest.importorskip("sklearn.mixture")
    shown = [each.motion for each in lt.io.lasa.load(name)]
    points = np.concatenate(
        [np.column_stack([m.times / m.times[-1], m.positions])[::10] for m in shown]
    )
    points = (points - points.mean(axis=0)) / points.std(axis=0)
    peer = sklearn_mixture.GaussianMixture(8, n_init=5, max_iter=500, tol=1e-5, random_state=1).fit(
        points
    )
    best = fit_mixture(points, 8).log_likelihood
    assert best >= peer.score(points)
    assert best >= fit_mixture(points, 8, starts=1).log_likelihood
    shuffled = np.random.default_rng(0).permutation(points)
    assert fit_mixture(shuffled, 8).log_likelihood == pytest.approx(best, abs=1e-9)
    refused("starts", fit_mixture, points, 8, starts=0)


def test_trace_shows_every_iteration_on_the_way_up():
    points = random_mixture(3, 2, seed=8).sample(300, seed=9)
    mixtures = trace_mixture(points, 4, iterations=6)
    heights = [mixture.log_density(points).mean() for mixture in mixtures]
    assert len(mixtures) == 7
    assert (np.diff(heights) > 0).all()


def test_trace_goes_on_from_a_given_mixture():
    points = random_mixture(3, 2, seed=8).sample(300, seed=9) * [1e-3, 1e4]
    whole = trace_mixture(points, 4, iterations=6)
    rest = trace_mixture(points, whole[2], iterations=4)
    for again, first in zip(rest, whole[2:], strict=True):
        np.testing.assert_allclose(again.means, first.means, rtol=1e-9)
        np.testing.assert_allclose(again.covariances, first.covariances, rtol=1e-6)
    refused("points", trace_mixture, points[:, :1], whole[2], iterations=1)


def test_units_do_not_matter():
    points = random_mixture(3, 2, seed=6).sample(400, seed=7)
    plain, scaled = fit_mixture(points, 3), fit_mixture(points * [1e-3, 1e4], 3)
    np.testing.assert_allclose(scaled.mixture.means, plain.mixture.means * [1e-3, 1e4], rtol=1e-6)


def test_number_of_components_is_that_of_well_separate_clusters():
    rng = np.random.default_rng(0)
    centres = np.array([[0, 0], [8, 0], [0, 8], [8, 8], [4, 16]])
    points = np.concatenate([c + rng.standard_normal((80, 2)) for c in centres])
    fit = choose_components(points, at_most=9)
    assert fit.mixture.count == 5


def test_samples_have_the_moments_of_the_mixture():
    mixture = random_mixture(2, 2)
    points = mixture.sample(200_000, seed=0)
    np.testing.assert_allclose(points.mean(axis=0), mixture.weights @ mixture.means, atol=0.02)


def test_singular_points_give_a_usable_mixture():
    line = np.column_stack([np.linspace(0, 1, 50), np.ones(50)])
    for points, count in ((line, 3), (np.ones((4, 2)), 2), (line[:1], 1)):
        mixture = fit_mixture(points, count).mixture
        mean, covariance = mixture.regress([[0.5]], inputs=[0])
        assert np.isfinite(mean).all()
        assert (covariance > 0).all()


def blobs(seed=0):
    rng = np.random.default_rng(seed)
    centres = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]])
    return centres, np.concatenate([c + rng.standard_normal((50, 2)) for c in centres])


def test_separate_clusters_are_found():
    centres, points = blobs()
    found = kmeans(points, 4, seed=0)
    gaps = np.linalg.norm(found.centres[:, None] - centres, axis=2)
    assert gaps.min(axis=0).max() < 0.5
    assert all(len(set(found.labels[50 * i : 50 * i + 50])) == 1 for i in range(4))


@given(st.integers(1, 30), st.integers(0, 1000))
def test_every_point_belongs_to_the_nearest_centre_and_no_cluster_is_empty(count, seed):
    points = np.random.default_rng(seed).standard_normal((30, 3))
    found = kmeans(points, count, seed=seed)
    squared = ((points[:, None] - found.centres) ** 2).sum(axis=2)
    own = squared[np.arange(30), found.labels]
    np.testing.assert_allclose(own, squared.min(axis=1), atol=1e-12)
    assert found.inertia == pytest.approx(own.sum())
    assert set(found.labels) == set(range(count))


def test_inertia_never_grows_from_step_to_step():
    _, points = blobs(1)
    found = kmeans(points, 7, seed=3)
    sums = [((points[:, None] - c) ** 2).sum(axis=2).min(axis=1).sum() for c in found.steps]
    assert len(sums) > 2
    assert (np.diff(sums) <= 1e-9).all()


def test_seeds_are_drawn_by_their_squared_distance():
    points = np.array([[0.0], [1.0], [3.0]])
    rng = np.random.default_rng(0)
    drawn = [tuple(kmeans(points, 2, seed=rng).steps[0][:, 0]) for _ in range(6000)]
    from_zero = [second for first, second in drawn if first == 0.0]
    assert from_zero.count(3.0) / len(from_zero) == pytest.approx(0.9, abs=0.02)


def test_identical_points_are_no_trouble():
    assert kmeans(np.ones((5, 2)), 3, seed=0).inertia == 0.0


def test_bad_arguments_are_refused_by_name():
    mixture = random_mixture()
    assert "components" in str(raised(FitError, fit_mixture, np.zeros((3, 2)), 4))
    refused("inputs", mixture.regress, [[0.0]], inputs=[7])
    refused("outputs", mixture.regress, [[0.0]], inputs=[0], outputs=[0])
    refused("weights", Mixture, [0.5, 0.6], np.zeros((2, 1)), np.ones((2, 1, 1)))
    refused("covariances", Mixture, [1.0], np.zeros((1, 2)), np.ones((1, 2, 2)))
    for points, count, name in (
        ([[0.0]], 2, "count"),
        ([0.0], 1, "points"),
        ([[np.nan]], 1, "points"),
    ):
        refused(name, kmeans, points, count, seed=0)


def test_random_seeds_are_any_points_and_end_no_better_on_the_whole():
    rng = np.random.default_rng(3)
    centres = 10.0 * rng.normal(size=(8, 2))
    points = np.concatenate([centre + 0.3 * rng.normal(size=(30, 2)) for centre in centres])
    ends = {
        seeding: [kmeans(points, 8, seed=seed, seeding=seeding).inertia for seed in range(20)]
        for seeding in ("plus_plus", "random")
    }
    assert np.median(ends["plus_plus"]) < np.median(ends["random"])
    first = kmeans(points, 8, seed=1, seeding="random").steps[0]
    assert {tuple(row) for row in first} <= {tuple(row) for row in points}
    refused("seeding", kmeans, points, 8, seed=1, seeding="far")
