"""Basis functions over the phase, and prior covariances of their weights."""

import numpy as np
import pytest

from leadthrough.models.promp.basis import KINDS, Basis, lines, raised

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


def test_rhythmic_functions_repeat_with_every_period():
    rhythmic = Basis("rhythmic", 9)
    for order in (0, 1, 2):
        np.testing.assert_allclose(rhythmic(PHASES, order), rhythmic(PHASES + 3, order), atol=1e-8)


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
