"""Steps of EM: the likelihood never falls."""

import numpy as np

from leadthrough.models import kmeans
from leadthrough.models.gaussians.mixture import MIN_VARIANCE, Steps


def climbed(steps, components, iterations):
    """Components after iterations of EM, and the mean log-likelihood before each."""
    history = []
    for _ in range(iterations):
        responsibilities, likelihood = steps.expect(components)
        history.append(likelihood)
        components = steps.maximise(responsibilities)
    return components, history


def test_likelihood_never_falls():
    rng = np.random.default_rng(2)
    points = np.concatenate([2.0 * c + rng.normal(size=(150, 3)) for c in rng.normal(size=(4, 3))])
    for seed in range(5):
        steps = Steps([points])
        start = steps.maximise(np.eye(6)[kmeans(points, 6, seed=seed).labels])
        _, history = climbed(steps, start, 60)
        assert np.diff(history).min() > -1e-10


def test_likelihood_never_falls_where_the_floor_holds_either():
    t = np.repeat(np.linspace(0, 1, 100), 2)
    points = np.column_stack([t, 2 * t, np.ones(200)])
    points = points - points.mean(axis=0)
    steps = Steps([points])
    start = steps.maximise(np.eye(4)[np.arange(200) % 4])
    components, history = climbed(steps, start, 100)
    assert np.diff(history).min() > -1e-8
    assert np.linalg.eigvalsh(components.covariances[0]).min() > 0.99 * MIN_VARIANCE
