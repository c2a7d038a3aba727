"""Estimated distributions of weights."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.models.promp.basis import Basis, smooth_prior


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
        given = [lt.Demonstration(lt.Trajectory(2 * u, curve)) for curve in curves]
        fitted = lt.ProMP(weights=8).fit(given).weights.covariance
        ours.append(np.linalg.norm(fitted - truth))
        samples.append(np.linalg.norm(np.cov(weights.T) - truth))
    assert np.mean(ours) <= 1.1 * np.mean(samples)
