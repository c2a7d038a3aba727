"""Point clouds against their balls one by one."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.planning import occupied

TURN = rotations.exp([[0.3, -0.7, 1.1]])[0]
PLACE = np.array([0.4, -0.2, 0.9])
POINTS = np.random.default_rng(1).uniform(-0.5, 0.5, (300, 3))
CLOUD = lt.PointCloud(POINTS, 0.05, PLACE, TURN)


def centres(cloud):
    return cloud.points @ rotations.to_matrix(cloud.orientation[None])[0].T + cloud.position


def test_distance_is_that_of_the_nearest_ball():
    queries = PLACE + np.random.default_rng(2).uniform(-1, 1, (400, 3))
    each = [lt.Sphere(0.05, centre).distance(queries) for centre in centres(CLOUD)]
    np.testing.assert_allclose(CLOUD.distance(queries), np.min(each, axis=0), atol=1e-12)
    assert (CLOUD.distance(centres(CLOUD)) < -0.049).all()


def test_bounds_hold_every_ball():
    away = np.abs(centres(CLOUD) - CLOUD.middle)
    np.testing.assert_allclose(away.max(axis=0) + 0.05, CLOUD.half_extents)
    reached = np.linalg.norm(away, axis=1).max() + 0.05
    assert CLOUD.bounding_radius == pytest.approx(reached)


def test_a_cloud_is_represented_by_its_size():
    assert "array (300, 3)" in repr(CLOUD)


def test_one_point_is_a_ball():
    one, ball = lt.PointCloud([PLACE], 0.1), lt.Sphere(0.1, PLACE)
    queries = np.random.default_rng(4).uniform(-1, 1, (50, 3))
    np.testing.assert_allclose(one.distance(queries), ball.distance(queries), atol=1e-15)
    np.testing.assert_allclose(one.half_extents, ball.half_extents)


def test_cells_of_a_map_are_occupied_by_the_balls():
    grid = lt.Grid((-0.4, -1.1, 0.1), 0.08, (20, 20, 20))
    expected = CLOUD.distance(grid.centres().reshape(-1, 3)) <= 0.02
    actual = occupied(grid, [CLOUD], margin=0.02)
    np.testing.assert_array_equal(actual, expected.reshape(grid.shape))
    assert 0 < actual.sum() < actual.size


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lt.PointCloud([], 0.1), "points: "),
        (lambda: lt.PointCloud(np.zeros((0, 3)), 0.1), "points: expected 1 to 1,000,000 points"),
        (lambda: lt.PointCloud(np.zeros((1_000_001, 3)), 0.1), "points: .* keep one point per"),
        (lambda: lt.PointCloud([[0, 0, np.nan]], 0.1), "points: "),
        (lambda: lt.PointCloud([[0, np.inf, 0]], 0.1), "points: "),
        (lambda: lt.PointCloud([[0, 0]], 0.1), "points: "),
        (lambda: lt.PointCloud([[0, 0, 0]], 0.0), "radius: "),
        (lambda: lt.PointCloud([[0, 0, 0]], np.nan), "radius: "),
        (lambda: lt.PointCloud([[0, 0, 0]], 0.1, (0, 0)), "position: "),
        (lambda: lt.PointCloud([[0, 0, 0]], 0.1, PLACE, (0, 0, 0, 0)), "orientation: "),
        (lambda: CLOUD.distance([0, 0, 0]), "points: "),
    ],
)
def test_impossible_clouds_are_refused(call, message):
    refused(message, call)
