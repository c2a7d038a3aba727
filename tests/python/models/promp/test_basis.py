"""Basis functions over the phase."""

import numpy as np
import pytest

from leadthrough.models.promp.basis import KINDS, Basis

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
