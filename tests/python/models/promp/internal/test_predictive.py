"""Posterior predictive distributions of weights."""

import numpy as np
import pytest

from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.inference import Seen
from leadthrough.models.promp.predictive import PosteriorPredictive


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
