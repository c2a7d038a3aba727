"""Learning of systems: gradients, bounds and convex programmes."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from leadthrough.models.dynamical import lyapunov, modified_ds, seds
from leadthrough.models.dynamical.linear_mixture import stable_matrices
from leadthrough.models.dynamical.lyapunov import Descent

RNG = np.random.default_rng(1)
X, V = RNG.normal(size=(2, 30, 3))


@pytest.mark.parametrize("objective", [seds._unlikelihood, seds._squared_error])
def test_gradients_of_the_objectives_of_seds(objective):
    k, d = 2, 3
    parts = RNG.normal(size=k + k * d + 4 * k * d * d)
    parts[k + k * d :].reshape(4, k, d, d)[[0, 3]] = np.triu(RNG.normal(size=(2, k, d, d)))
    numeric = approx_fprime(parts, lambda p: objective(p, k, d, X, V)[0], 1e-6)
    np.testing.assert_allclose(objective(parts, k, d, X, V)[1], numeric, atol=2e-4)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("objective", [seds._unlikelihood, seds._squared_error])
@pytest.mark.parametrize("far", [-1e3, 1e3])
def test_far_steps_of_a_line_search_are_finite(objective, far):
    k, d = 2, 3
    parts = RNG.normal(size=k + k * d + 4 * k * d * d)
    parts[k + k * d :].reshape(4, k, d, d)[[0, 3]] = far * np.eye(d)
    value, gradient = objective(parts, k, d, X, V)
    assert np.isfinite(value)
    assert np.isfinite(gradient).all()


@pytest.mark.parametrize("energy", [lyapunov, modified_ds])
def test_gradients_of_energies_and_of_their_learning(energy):
    count = 3
    size = {lyapunov: 9 + count * 21, modified_ds: count * 5}[energy]
    packed = RNG.normal(size=size)
    gradient, back = energy._gradient(packed, X, count)
    numeric = approx_fprime(packed, lambda p: (energy._gradient(p, X, count)[0] * V).sum(), 1e-7)
    np.testing.assert_allclose(back(V), numeric, rtol=1e-3, atol=1e-3)
    built = energy._built(packed, 3, count)
    slopes = np.array([approx_fprime(x, lambda p: built.value(p[None])[0], 1e-7) for x in X])
    np.testing.assert_allclose(built.gradient(X), slopes, rtol=1e-3, atol=1e-3)
    cosines = (gradient * slopes).sum(axis=1) / np.linalg.norm(gradient, axis=1)
    np.testing.assert_allclose(cosines, np.linalg.norm(slopes, axis=1), rtol=1e-3)
    assert ((X * built.gradient(X)).sum(axis=1) > 0.0).all()


def test_bound_of_a_units_slope_along_rays_holds_for_every_offset():
    offsets, t = np.linspace(-8.0, 30.0, 200), np.linspace(-60.0, 5.0, 20_001)
    largest = [(-t / np.cosh(t + b) ** 2).max() for b in offsets]
    assert (np.array(largest) < modified_ds.slope_bounds(offsets)).all()


def test_correction_is_the_least_one_with_which_the_energy_falls():
    descent = Descent(slowest=0.1, near=0.05)
    uphill = RNG.normal(size=X.shape)
    made = descent.corrected(V, X, uphill)
    unit = uphill / np.linalg.norm(uphill, axis=1, keepdims=True)
    least = 0.1 * -np.expm1(-np.linalg.norm(X, axis=1) / 0.05)
    slopes = (made * unit).sum(axis=1)
    assert (slopes <= -least + 1e-12).all()
    changed = np.linalg.norm(made - V, axis=1) > 0.0
    assert changed.any()
    assert not changed.all()
    np.testing.assert_allclose(slopes[changed], -least[changed])
    # Only along the gradient: no shorter correction reaches as far down.
    across = (made - V) - ((made - V) * unit).sum(axis=1, keepdims=True) * unit
    np.testing.assert_allclose(across, 0.0, atol=1e-12)


def test_programme_finds_stable_matrices_again_and_makes_others_stable():
    weights, metric = RNG.random((30, 3)), np.diag([1.0, 2.0, 0.5])
    root, skew = RNG.normal(size=(2, 3, 3, 3))
    turned = skew - skew.transpose(0, 2, 1)
    matrices = np.linalg.solve(metric, turned - root @ root.transpose(0, 2, 1) - np.eye(3))
    v = np.einsum("nk,kij,nj->ni", weights, matrices, X)
    found = stable_matrices(weights, X, v, metric=metric, decay=0.1, ridge=1e-10)
    np.testing.assert_allclose(found, matrices, atol=1e-4)
    found = stable_matrices(weights, X, -v, metric=metric, decay=0.1, ridge=1e-10)
    falling = metric @ found + found.transpose(0, 2, 1) @ metric + 0.2 * metric
    assert np.linalg.eigvalsh(falling).max() < 1e-7
