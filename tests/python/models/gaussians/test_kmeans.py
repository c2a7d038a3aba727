"""k-means and k-means++."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadthrough.errors import InvalidInput
from leadthrough.models import kmeans


def blobs(seed=0):
    rng = np.random.default_rng(seed)
    centres = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]])
    return centres, np.concatenate([c + rng.standard_normal((50, 2)) for c in centres])


def test_separate_clusters_are_found():
    centres, points = blobs()
    found = kmeans(points, 4, seed=0)
    gaps = np.linalg.norm(found.centres[:, None] - centres, axis=2)
    assert gaps.min(axis=0).max() < 0.5
    assert all(len(set(found.labels[50 * i : 50 * i + 50])) == 1 for i in range(4))


@given(st.integers(1, 30), st.integers(0, 1000))
def test_every_point_belongs_to_the_nearest_centre_and_no_cluster_is_empty(count, seed):
    points = np.random.default_rng(seed).standard_normal((30, 3))
    found = kmeans(points, count, seed=seed)
    squared = ((points[:, None] - found.centres) ** 2).sum(axis=2)
    own = squared[np.arange(30), found.labels]
    np.testing.assert_allclose(own, squared.min(axis=1), atol=1e-12)
    assert found.inertia == pytest.approx(own.sum())
    assert set(found.labels) == set(range(count))


def test_inertia_never_grows_from_step_to_step():
    _, points = blobs(1)
    found = kmeans(points, 7, seed=3)
    sums = [((points[:, None] - c) ** 2).sum(axis=2).min(axis=1).sum() for c in found.steps]
    assert len(sums) > 2
    assert (np.diff(sums) <= 1e-9).all()


def test_seeds_are_drawn_by_their_squared_distance():
    points = np.array([[0.0], [1.0], [3.0]])
    rng = np.random.default_rng(0)
    drawn = [tuple(kmeans(points, 2, seed=rng).steps[0][:, 0]) for _ in range(6000)]
    from_zero = [second for first, second in drawn if first == 0.0]
    assert from_zero.count(3.0) / len(from_zero) == pytest.approx(0.9, abs=0.02)


def test_identical_points_are_no_trouble():
    assert kmeans(np.ones((5, 2)), 3, seed=0).inertia == 0.0


def test_bad_arguments_are_refused_by_name():
    for points, count, name in (
        ([[0.0]], 2, "count"),
        ([0.0], 1, "points"),
        ([[np.nan]], 1, "points"),
    ):
        with pytest.raises(InvalidInput, match=name):
            kmeans(points, count, seed=0)


def test_random_seeds_are_any_points_and_end_no_better_on_the_whole():
    rng = np.random.default_rng(3)
    centres = 10.0 * rng.normal(size=(8, 2))
    points = np.concatenate([centre + 0.3 * rng.normal(size=(30, 2)) for centre in centres])
    ends = {
        seeding: [kmeans(points, 8, seed=seed, seeding=seeding).inertia for seed in range(20)]
        for seeding in ("plus_plus", "random")
    }
    assert np.median(ends["plus_plus"]) < np.median(ends["random"])
    first = kmeans(points, 8, seed=1, seeding="random").steps[0]
    assert {tuple(row) for row in first} <= {tuple(row) for row in points}
    with pytest.raises(InvalidInput, match="seeding"):
        kmeans(points, 8, seed=1, seeding="far")
