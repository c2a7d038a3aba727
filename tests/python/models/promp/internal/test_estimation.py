"""Estimated distributions of weights: EM of noisy and partial demonstrations."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import leadthrough as lt
from leadthrough.errors import FitError
from leadthrough.models.coordinates import Coordinates, scales
from leadthrough.models.promp.basis import KINDS, Basis, lines, raised, smooth_prior
from leadthrough.models.promp.estimation import (
    Samples,
    Sums,
    expectation,
    expectation_maximisation,
    log_prior,
    maximisation,
)
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.model import from_archive

BASIS = Basis("gaussian", 8)
NOISE = 0.05


def curves(count, seed, *, noise=NOISE):
    """Phases (60,) and noisy curves (count, 60, 2) of random weights; and the curves without it."""
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, 60)
    offsets = 0.3 * rng.standard_normal((count, 1, 2))
    bumps = 0.2 * rng.standard_normal((count, 1, 2))
    shape = np.column_stack([u, np.sin(3 * u)])
    true = shape + offsets * (1 - u)[:, None] + bumps * np.sin(np.pi * u)[:, None]
    return u, true + noise * rng.standard_normal(true.shape), true


def test_posterior_density_never_falls():
    u, noisy, _ = curves(6, seed=1)
    phases = [u[:40], u[20:], u, u[10:50], u, u]
    columns = [noisy[0][:40], noisy[1][20:], noisy[2], noisy[3][10:50], noisy[4], noisy[5]]
    scale = scales(columns, Coordinates("points", 2))
    history = expectation_maximisation(BASIS, Samples(phases, columns, scale)).history
    assert len(history) > 3
    assert np.diff(history).min() > -1e-6


def partial(seed):
    """Some distribution of weights, and samples (n, 2) of parts with their functions (n, 8)."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((16, 16))
    weights = Gaussian(rng.standard_normal(16), 0.02 * root @ root.T + 0.1 * np.eye(16))
    u, noisy, _ = curves(4, seed)
    parts = [slice(0, 40), slice(0, 40), slice(25, 60), slice(10, 50)]
    return weights, [(BASIS(u[part]), each[part]) for part, each in zip(parts, noisy, strict=True)]


def test_the_likelihood_is_that_of_all_samples_at_once():
    weights, given = partial(seed=5)
    noise = np.array([0.01, 0.04])
    _, likelihood = expectation([Sums.of(*each) for each in given], weights, noise)
    expected = 0.0
    for rows, values in given:
        every = np.kron(np.eye(2), rows)
        spread = every @ weights.covariance @ every.T + np.diag(np.repeat(noise, len(rows)))
        expected += multivariate_normal(every @ weights.mean, spread).logpdf(values.T.ravel())
    assert likelihood == pytest.approx(expected, rel=1e-9)


def test_the_maximisation_finds_the_most_probable_covariance():
    weights, given = partial(seed=6)
    sums = [Sums.of(*each) for each in given]
    estimates, _ = expectation(sums, weights, np.array([0.01, 0.04]))
    base = np.diag(np.linspace(0.5, 2.0, 16))
    found, _ = maximisation(sums, estimates, base)

    def expected_density(covariance):
        normal = multivariate_normal(found.mean, covariance)
        inverse = np.linalg.inv(covariance)
        lost = sum(np.trace(inverse @ each.covariance) for each in estimates)
        told = sum(normal.logpdf(each.mean) for each in estimates)
        return told - 0.5 * lost + log_prior(covariance, base)

    most = expected_density(found.covariance)
    for factor in (0.99, 1.01):
        assert expected_density(factor * found.covariance) < most
        assert expected_density(found.covariance + (factor - 1.0) * np.diag(np.diag(base))) < most


def test_noise_is_found_and_smoothed_away():
    u, noisy, true = curves(20, seed=2)
    given = [lt.Trajectory(u, each) for each in noisy]
    skill = lt.ProMP(weights=8, estimator="em").fit(given)
    np.testing.assert_allclose(np.sqrt(skill.noise), NOISE, rtol=0.1)
    mean, _ = skill.distribution(u)
    assert np.abs(mean - true.mean(axis=0)).max() < 2 * NOISE / np.sqrt(20) + 0.02


def test_parts_of_a_motion_make_up_the_whole():
    u, noisy, true = curves(24, seed=3, noise=0.01)
    parts, phases = [], []
    for i, each in enumerate(noisy):
        rows = slice(0, 38) if i % 2 else slice(22, 60)
        parts.append(lt.Trajectory(2.0 * (1 + i % 3) * u[rows], each[rows]))
        phases.append(u[rows])
    skill = lt.ProMP(weights=8, estimator="em").fit(parts, phases=phases)
    mean, covariance = skill.distribution(u * skill.duration)
    assert np.abs(mean - true.mean(axis=0)).max() < 0.1
    assert skill.duration == pytest.approx(4.0)
    spread = np.sqrt(np.einsum("nii->ni", covariance)[30])
    np.testing.assert_allclose(spread, true[:, 30].std(axis=0), rtol=0.5)


def test_a_part_that_nobody_showed_is_named():
    u, noisy, _ = curves(2, seed=4)
    parts = [lt.Trajectory(u[:30], each[:30]) for each in noisy]
    with pytest.raises(FitError, match=r"phases 0\.492 to 1;"):
        lt.ProMP(estimator="em").fit(parts, phases=[u[:30], u[:30]])
    with pytest.raises(FitError, match=r"phases 0 to 0\.508;"):
        lt.ProMP(estimator="em").fit(parts, phases=[u[30:], u[30:]])


@pytest.mark.parametrize("count", [6, 60])
def test_known_distribution_is_recovered_as_well_as_by_the_sample_covariance(count):
    basis, size = Basis("gaussian", 8, margin=0.25), 2
    truth = smooth_prior(basis, np.array([0.3, 0.5]))
    u = np.linspace(0.0, 1.0, 60)
    rows = np.kron(np.eye(size), basis(u))
    middle = np.concatenate([np.linspace(0, 2, 8), np.linspace(1, -1, 8)])
    ours, samples = [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        weights = rng.multivariate_normal(middle, truth, count)
        curves = (weights @ rows.T).reshape(count, size, -1).transpose(0, 2, 1)
        given = [lt.Trajectory(2 * u, curve) for curve in curves]
        fitted = lt.ProMP(weights=8).fit(given).weights.covariance
        ours.append(np.linalg.norm(fitted - truth))
        samples.append(np.linalg.norm(np.cov(weights.T) - truth))
    assert np.mean(ours) <= 1.1 * np.mean(samples)


PHASES = np.linspace(0.0, 1.0, 301)


@pytest.fixture(params=KINDS)
def basis(request):
    return Basis(request.param, 12)


def test_functions_sum_to_one(basis):
    np.testing.assert_allclose(basis(PHASES).sum(axis=1), 1.0, atol=1e-12)
    assert (basis(PHASES) >= 0.0).all()


@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_are_those_of_central_differences(basis, order):
    step = 1e-5
    inside = PHASES[1:-1]
    ahead, behind = (basis(inside + s, order - 1) for s in (step, -step))
    difference = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(basis(inside, order), difference, atol=2e-3 * 12**order)


def test_each_function_is_largest_near_its_centre(basis):
    inside = (basis.centres >= 0.0) & (basis.centres <= 1.0)
    largest = PHASES[basis(PHASES).argmax(axis=0)]
    gap = np.abs(largest - basis.centres)[inside]
    if basis.is_rhythmic:  # phases 0 and 1 are the same
        gap = np.minimum(gap, 1.0 - gap)
    assert gap.max() < 0.06


def test_straight_lines_are_not_rough():
    for kind in ("bspline", "gaussian"):
        line = np.linspace(-1.0, 2.0, 12)
        assert line @ Basis(kind, 12).roughness @ line == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("end", [0, 1])
def test_a_motion_that_varies_at_one_end_only_is_raised_to_the_least_at_the_other(end):
    basis, least = Basis("gaussian", 12), 0.03
    ramp = lines(basis)[:, [end]]
    covariance = raised(ramp @ ramp.T, basis, least)
    spread = np.sqrt(np.einsum("nk,kl,nl->n", basis(PHASES), covariance, basis(PHASES)))
    assert spread.min() >= 0.95 * least
    np.testing.assert_allclose(spread[[0, -1]], [1.0, least][:: 1 - 2 * end], rtol=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_curves_are_products_with_the_weights_on_any_number_of_threads(kind):
    basis, phases = Basis(kind, 9), np.linspace(0.0, 1.0, 301)
    weights, paces = np.random.default_rng(0).normal(size=(5, 2 * 9)), np.array([1.0, 0.5, 0.25])
    blocks, certain = basis.curves(phases, weights, paces, most=3, threads=1)
    assert certain
    assert [len(each) for each in blocks] == [3, 2]
    threaded, _ = basis.curves(phases, weights, paces, most=3, threads=3)
    for one, three in zip(blocks, threaded, strict=True):
        assert one.tobytes() == three.tobytes()
    rows = np.stack([basis(phases, order) * pace for order, pace in enumerate(paces)])
    wanted = np.einsum("onk,mdk->mond", rows, weights.reshape(5, 2, 9))
    scale = np.abs(wanted).max(axis=(0, 2, 3), keepdims=True)
    np.testing.assert_allclose(np.concatenate(blocks) / scale, wanted / scale, atol=1e-14)


def test_files_without_a_margin_have_the_one_of_their_time():
    u = np.linspace(0.0, 1.0, 100)
    shown = [lt.Trajectory(u, np.column_stack([u, u**2]))]
    skill = lt.ProMP(weights=8, margin=1.0).fit(shown)
    settings, arrays = skill.to_archive()
    settings["model"].pop("margin")
    again = from_archive(settings, arrays)
    np.testing.assert_array_equal(again.generate().positions, skill.generate().positions)
    assert lt.ProMP(weights=8).fit(shown).basis.centres[0] == pytest.approx(-0.25 / 6.5)
