"""Regression of aligned curves on their ends."""

import numpy as np

from leadthrough.models.aligned.predictor import _Fade


def test_the_fade_is_the_mean_of_a_gaussian_conditioned_on_both_ends():
    rng = np.random.default_rng(3)
    n, prior, weights = 7, 0.3, np.full(5, 0.2)
    rows = rng.normal(size=(5, n, 1))
    mean = rows.mean(axis=0)
    ends = rng.normal(size=(2, 1))
    linear = np.stack([1.0 - np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n)])
    fade = _Fade(rows, weights[None, None], mean[None, None], ends[None])
    found = fade.rows(linear[None, None], prior)[0, 0, :, 0]
    off = (rows - mean)[:, :, 0]
    variance = (off[:, [0, -1]] ** 2).sum() / 5
    joint = off.T @ off / 5 + prior * variance * linear.T @ linear
    outer = joint[:, [0, -1]] @ np.linalg.inv(joint[np.ix_([0, -1], [0, -1])])
    truth = mean[:, 0] + outer @ (ends - mean[[0, -1]])[:, 0]
    np.testing.assert_allclose(found, truth, atol=1e-12)
