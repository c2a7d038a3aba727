import numpy as np
import pytest
import scipy.ndimage
from hypothesis import given, settings
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.planning import distance_transform, occupied, occupied_by_points
from leadthrough.planning.speed_map import add_passable_obstacles

TURNED = np.array([0.8, 0.2, -0.4, 0.4])
SHAPES = [
    lt.Box((0.3, 0.5, 0.2), (0.1, 0.2, 0.0), TURNED),
    lt.Sphere(0.25, (0.3, -0.2, 0.1)),
    lt.Capsule(0.1, 0.4, (-0.2, 0.1, 0.05), TURNED),
    lt.Cylinder(0.15, 0.2, (-0.1, -0.3, 0.0), TURNED),
    lt.Sphere(0.3, (5.0, 5.0, 5.0)),
]


@pytest.mark.parametrize("margin", [0.0, 0.07])
def test_cells_are_occupied_where_a_shape_is_nearer_than_the_margin(margin):
    grid = lt.Grid((-0.5, -0.6, -0.4), (0.05, 0.06, 0.04), (20, 20, 20))
    points = grid.centres().reshape(-1, 3)
    expected = np.min([shape.distance(points) for shape in SHAPES], axis=0) <= margin
    actual = occupied(grid, SHAPES, margin=margin)
    np.testing.assert_array_equal(actual, expected.reshape(grid.shape))
    assert 0 < actual.sum() < actual.size


def test_a_plane_grid_is_cut_at_height_zero():
    grid = lt.Grid((-0.5, -0.5), 0.02, (50, 50))
    flat = grid.centres().reshape(-1, 2)
    points = np.column_stack([flat, np.zeros(len(flat))])
    expected = np.min([shape.distance(points) for shape in SHAPES], axis=0) <= 0.0
    np.testing.assert_array_equal(occupied(grid, SHAPES), expected.reshape(grid.shape))


@pytest.mark.parametrize(("height", "in_the_tube"), [(0.0, True), (0.28, False)])
def test_ways_round_lead_only_where_an_obstacle_stands_in_a_tube(height, in_the_tube):
    grid = lt.Grid((-0.5, -0.5), 0.02, (51, 51))
    speed = np.full(grid.shape, 0.1)
    speed[:, 23:28] = 1.0  # a tube along x, 0.05 m to either side
    ball = [lt.Sphere(0.15, (0.0, height, 0.0))]
    found = add_passable_obstacles(speed, grid, ball, band=0.1, saturation=0.1, reach=0.2)
    assert (found > speed).any() == in_the_tube


def test_no_obstacle_occupies_nothing():
    assert not occupied(lt.Grid((0.0, 0.0), 1.0, (3, 3)), []).any()


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32), st.lists(st.integers(1, 12), min_size=2, max_size=3), st.floats(0.1, 4.0)
)
def test_cells_near_a_point_cloud_are_occupied_and_no_others(seed, shape, radius):
    rng = np.random.default_rng(seed)
    d = len(shape)
    grid = lt.Grid(rng.normal(size=d), rng.uniform(0.3, 1.5, d), tuple(shape))
    low, high = -3.0 * grid.spacing, (np.array(shape) + 3.0) * grid.spacing
    points = grid.origin + rng.uniform(low, high, (int(rng.integers(0, 8)), d))
    gaps = np.linalg.norm(grid.centres()[..., None, :] - points, axis=-1)
    expected = (gaps <= radius).any(axis=-1)
    np.testing.assert_array_equal(occupied_by_points(grid, points, radius=radius), expected)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(1, 14), min_size=2, max_size=3),
    st.floats(0.001, 0.9),
    st.integers(0, 2**32),
)
def test_distances_equal_scipy_for_any_spacing(shape, share, seed):
    rng = np.random.default_rng(seed)
    mask = rng.random(shape) < share
    mask.flat[int(rng.integers(mask.size))] = True
    spacing = rng.uniform(0.1, 3.0, len(shape))
    expected = scipy.ndimage.distance_transform_edt(~mask, sampling=spacing)
    np.testing.assert_allclose(distance_transform(mask, spacing=spacing), expected, rtol=1e-12)


def test_without_a_cell_every_distance_is_infinite():
    assert np.isinf(distance_transform(np.zeros((4, 5), bool))).all()
