"""Dynamic time warping and Frechet distances, against their definitions."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from leadthrough.preprocess import dtw_distance, frechet_distance

DISTANCES = [dtw_distance, frechet_distance]


def curves(at_least=1, at_most=6):
    shapes = st.tuples(st.integers(at_least, at_most), st.just(2))
    return arrays(float, shapes, elements=st.floats(-9, 9))


def by_recursion(a, b, combine):
    @cache
    def best(i, j):
        distance = np.linalg.norm(a[i] - b[j])
        before = [(i - 1, j), (i, j - 1), (i - 1, j - 1)]
        costs = [best(k, m) for k, m in before if k >= 0 and m >= 0]
        return combine(distance, min(costs)) if costs else distance

    return best(len(a) - 1, len(b) - 1)


@given(curves(), curves())
def test_dtw_and_frechet_agree_with_their_definitions(a, b):
    assert dtw_distance(a, b) == pytest.approx(by_recursion(a, b, lambda d, c: d + c))
    assert frechet_distance(a, b) == pytest.approx(by_recursion(a, b, max))


@pytest.mark.parametrize("distance", DISTANCES)
@given(a=curves(), b=curves())
def test_distances_are_symmetric_and_zero_only_for_the_same_curve(distance, a, b):
    assert distance(a, b) == distance(b, a)
    assert distance(a, a) == 0
    assert distance(a, np.repeat(a, 3, axis=0)) == 0
    assert distance(a, b) >= np.linalg.norm(a[-1] - b[-1]) * (1 - 1e-15)


@given(curves(), curves(), curves())
def test_frechet_keeps_the_triangle_inequality(a, b, c):
    assert frechet_distance(a, c) <= frechet_distance(a, b) + frechet_distance(b, c) + 1e-12
