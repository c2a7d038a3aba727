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
    (found,) = fade.rows(linear[None, None], [(prior, False)])
    found = found[0, 0, :, 0]
    off = (rows - mean)[:, :, 0]
    variance = (off[:, [0, -1]] ** 2).sum() / 5
    joint = off.T @ off / 5 + prior * variance * linear.T @ linear
    outer = joint[:, [0, -1]] @ np.linalg.inv(joint[np.ix_([0, -1], [0, -1])])
    truth = mean[:, 0] + outer @ (ends - mean[[0, -1]])[:, 0]
    np.testing.assert_allclose(found, truth, atol=1e-12)


def test_a_combination_is_the_regression_of_what_the_fade_leaves_on_all_columns_of_both_ends():
    rng = np.random.default_rng(4)
    k, n, size, prior = 6, 9, 2, 0.3
    weights = rng.dirichlet(np.ones(k))
    rows = rng.normal(size=(k, n, size))
    mean = np.einsum("k,knd->nd", weights, rows)
    linear = np.stack([1.0 - np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n)])[None, None]

    def between(offsets, *, combined):
        ends = mean[[0, -1]] + offsets.reshape(2, size)
        fade = _Fade(rows, weights[None, None], mean[None, None], ends[None])
        (found,) = fade.rows(linear, [(prior, combined)])
        return found[0, 0] - mean

    off = (rows - mean)[:, [0, -1]].reshape(k, -1)
    left = rows - mean - np.array([between(each, combined=False) for each in off])
    pull = 0.015 * (weights * (off**2).sum(axis=1)).sum() / size + 0.05**2
    tall = np.vstack([np.sqrt(weights)[:, None] * off, np.sqrt(pull) * np.eye(2 * size)])
    seen = np.vstack(
        [np.sqrt(weights)[:, None] * left.reshape(k, -1), np.zeros((2 * size, n * size))]
    )
    regression = np.linalg.lstsq(tall, seen, rcond=None)[0]
    asked = rng.normal(size=2 * size)
    truth = between(asked, combined=False) + (asked @ regression).reshape(n, size)
    np.testing.assert_allclose(between(asked, combined=True), truth, atol=1e-10)
