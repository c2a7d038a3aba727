"""Mixtures and energies of other laboratories' libraries are read as they mean them."""

from types import SimpleNamespace

import numpy as np
from scipy.stats import multivariate_normal

from leadthrough.models import CLFDM
from leadthrough_studies.comparison import authors

RNG = np.random.default_rng(0)
K, D = 3, 2


def covariances(size):
    """One for each component, beside each other as MATLAB stores them."""
    roots = RNG.normal(size=(K, size, size))
    each = roots @ roots.transpose(0, 2, 1) + np.eye(size)
    return each, np.hstack(list(each))


def test_a_mixture_and_an_energy_of_clf_dm_are_read_as_the_library_means_them():
    means, weights = RNG.normal(size=(2 * D, K)), np.array([[0.2, 0.3, 0.5]])
    joint, stored = covariances(2 * D)
    centres = np.hstack([np.zeros((D, 1)), RNG.normal(size=(D, K - 1))])
    matrices, beside = covariances(D)
    octave = SimpleNamespace(
        run=lambda *_, **__: [weights, means, stored, weights, centres, beside]
    )
    samples = SimpleNamespace(scale=np.array([40.0, 40.0]), duration=4.0)
    field = authors._AuthorsCLFDM(octave, CLFDM()).learn(samples)

    x = RNG.normal(size=(20, D))
    density = [
        w * multivariate_normal(m[:D], s[:D, :D]).pdf(x)
        for w, m, s in zip(weights[0], means.T, joint, strict=True)
    ]
    conditional = [
        m[D:] + (x - m[:D]) @ np.linalg.solve(s[:D, :D], s[:D, D:])
        for m, s in zip(means.T, joint, strict=True)
    ]
    wanted = np.einsum("kn,knd->nd", density / np.sum(density, axis=0), conditional)

    away = x[None] - centres.T[:, None]
    terms = np.einsum("nd,kde,kne->kn", x, matrices, away)
    value = weights[0, 0] * terms[0] + weights[0, 1:] @ np.maximum(terms[1:], 0.0) ** 2
    assert np.allclose(field.energy(x), value)

    # It is the regression if the energy falls fast enough, and else falls at the least rate.
    step = 1e-6
    slope = np.stack([field.energy(x + step * e) - field.energy(x - step * e) for e in np.eye(D)])
    slope = slope.T / (2.0 * step)
    size = samples.scale[0]
    rate = samples.duration / size * -np.expm1(-0.1 * size**2 * (x**2).sum(axis=1))
    least = rate * np.linalg.norm(slope, axis=1)
    falls = (slope * wanted).sum(axis=1)
    assert 0 < np.sum(falls > -least) < len(x)
    made = (slope * field.velocity(x)).sum(axis=1)
    assert np.allclose(made, np.minimum(falls, -least), rtol=1e-5)
    assert np.allclose(field.velocity(x)[falls <= -least], wanted[falls <= -least])
