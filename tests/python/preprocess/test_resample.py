"""Arc length, resampling, and distances of curves."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from refusals import refused

from leadthrough.preprocess import dtw_distance, frechet_distance, resample

few_points = arrays(
    float, st.tuples(st.integers(1, 12), st.integers(1, 3)), elements=st.floats(-9, 9)
)


def test_arc_length_is_the_length_walked_so_far():
    assert np.array_equal(resample.arc_length([[0, 0], [3, 4], [3, 4], [3, 5]]), [0, 5, 5, 6])
    assert np.array_equal(resample.arc_length([[1, 2]]), [0])


def test_points_are_spaced_equally_along_the_curve():
    corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 3.0]]
    assert np.array_equal(
        resample.by_arc_length(corner, 5), [[0, 0], [1, 0], [1, 1], [1, 2], [1, 3]]
    )


def test_a_semicircle_is_walked_at_even_angles():
    uneven = np.pi * np.linspace(0, 1, 20_001) ** 3
    angles = np.linspace(0, np.pi, 50)
    resampled = resample.by_arc_length(np.column_stack([np.cos(uneven), np.sin(uneven)]), 50)
    np.testing.assert_allclose(
        resampled, np.column_stack([np.cos(angles), np.sin(angles)]), atol=1e-6
    )


@given(few_points, st.integers(2, 30))
def test_the_ends_stay_and_the_spacing_is_never_exceeded(curve, count):
    resampled = resample.by_arc_length(curve, count)
    assert resampled.shape == (count, curve.shape[1])
    np.testing.assert_allclose(resampled[[0, -1]], curve[[0, -1]], atol=1e-12)
    spacing = resample.arc_length(curve)[-1] / (count - 1)
    assert (np.linalg.norm(np.diff(resampled, axis=0), axis=1) <= spacing + 1e-12).all()


@given(few_points, st.lists(st.integers(1, 4), min_size=12, max_size=12), st.integers(2, 30))
def test_pauses_do_not_matter(curve, repeats, count):
    paused = np.repeat(curve, repeats[: len(curve)], axis=0)
    np.testing.assert_allclose(
        resample.by_arc_length(paused, count), resample.by_arc_length(curve, count), atol=1e-12
    )


@given(few_points, arrays(float, (8,), elements=st.floats(0, 1)))
def test_more_samples_of_the_same_polygon_do_not_matter(curve, parts):
    segments = np.arange(len(curve) - 1) if len(curve) > 1 else np.zeros(0, int)
    dense = [curve[:1]]
    for i in segments:
        part = np.sort(parts)[:, None]
        dense += [(1 - part) * curve[i] + part * curve[i + 1], curve[i + 1 : i + 2]]
    np.testing.assert_allclose(
        resample.by_arc_length(np.vstack(dense), 9), resample.by_arc_length(curve, 9), atol=1e-9
    )


def test_a_curve_that_never_moves_stays_a_point():
    assert np.array_equal(resample.by_arc_length([[1.0, 2.0]] * 3, 4), [[1, 2]] * 4)
    assert np.array_equal(resample.by_arc_length([[1.0, 2.0]], 2), [[1, 2]] * 2)


def test_tiny_steps_beside_a_long_way_are_harmless():
    curve = [[0.0], [1e-300], [1e20], [1e20 + 1e4], [2e20]]
    resampled = resample.by_arc_length(curve, 3)
    np.testing.assert_allclose(resampled, [[0], [1e20], [2e20]])


def test_bad_points_and_counts_are_refused():
    for points in [
        [],
        np.zeros((0, 2)),
        np.zeros((3, 0)),
        [1.0, 2.0],
        [[np.nan, 0]],
        None,
        [[1e308, 0], [-1e308, 0]],
    ]:
        for call in (resample.arc_length, lambda p: resample.by_arc_length(p, 5)):
            refused("points: ", call, points)
    for count in [1, 0, -3, 2.0, None, True]:
        refused("count: expected an integer", resample.by_arc_length, [[0.0], [1.0]], count)


DISTANCES = [dtw_distance, frechet_distance]


def curves(at_least=1, at_most=6):
    shapes = st.tuples(st.integers(at_least, at_most), st.just(2))
    return arrays(float, shapes, elements=st.floats(-9, 9))


def by_recursion(a, b, combine, band=99):
    n, m = (len(a), len(b)) if len(a) >= len(b) else (len(b), len(a))

    @cache
    def best(i, j):
        along, across = (i, j) if len(a) >= len(b) else (j, i)
        if abs(across - along * (m - 1) // max(n - 1, 1)) > band:
            return np.inf
        distance = np.linalg.norm(a[i] - b[j])
        before = [(i - 1, j), (i, j - 1), (i - 1, j - 1)]
        costs = [best(k, m) for k, m in before if k >= 0 and m >= 0]
        return combine(distance, min(costs)) if costs else distance

    return best(len(a) - 1, len(b) - 1)


@given(curves(), curves())
def test_dtw_and_frechet_agree_with_their_definitions(a, b):
    assert dtw_distance(a, b) == pytest.approx(by_recursion(a, b, lambda d, c: d + c))
    assert frechet_distance(a, b) == pytest.approx(by_recursion(a, b, max))


@given(curves(), curves(), st.integers(1, 4))
def test_a_band_leaves_the_pairs_beside_it_out(a, b, band):
    summed = by_recursion(a, b, lambda d, c: d + c, band)
    assert dtw_distance(a, b, band=band) == pytest.approx(summed)
    assert frechet_distance(a, b, band=band) == pytest.approx(by_recursion(a, b, max, band))


@pytest.mark.parametrize("distance", DISTANCES)
def test_curves_of_a_million_points_are_refused_unless_they_have_a_band(distance):
    long = np.zeros((1_000_000, 1))
    refused(r"a, b: .*resample the curves, or .*: band=4999", distance, long, long)
    refused(r"a, b: .* got 1,000,000 times 200,001", distance, long, long, band=100_000)
    refused("band: expected an integer >= 1, got 0", distance, long, long, band=0)
    assert distance(long, long + 1.0, band=1) >= 1.0


@pytest.mark.parametrize("distance", DISTANCES)
@given(a=curves(), b=curves())
def test_distances_are_symmetric_and_zero_only_for_the_same_curve(distance, a, b):
    assert distance(a, b) == distance(b, a)
    assert distance(a, a) == 0
    assert distance(a, np.repeat(a, 3, axis=0)) == 0
    assert distance(a, b) >= np.linalg.norm(a[-1] - b[-1]) * (1 - 1e-15)
