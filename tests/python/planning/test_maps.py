"""Grids, obstacles in them, and FM2 speed maps."""

import itertools

import numpy as np
import pytest
import scipy.ndimage
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp
from refusals import refused

import leadthrough as lt
from leadthrough.planning import (
    distance_transform,
    fm2_speed,
    occupied,
    occupied_by_points,
    plan,
    plan_many,
)

CELLS = lt.Grid((1.0, -2.0, 0.5), (0.1, 0.2, 0.3), (4, 5, 6))


def test_centres_lie_at_whole_coordinates():
    indices = np.argwhere(np.ones(CELLS.shape))
    centres = CELLS.centres().reshape(-1, 3)
    np.testing.assert_allclose(CELLS.coordinates(centres), indices, atol=1e-12)
    np.testing.assert_array_equal(CELLS.cells_of(centres), indices)
    np.testing.assert_allclose(CELLS.points_at(indices), centres, atol=1e-15)


@given(hnp.arrays(float, (3,), elements=st.floats(-3.0, 9.0)))
def test_a_point_is_contained_exactly_if_it_has_a_cell(coordinates):
    point = CELLS.points_at([coordinates])
    if CELLS.contains(point)[0]:
        cell = CELLS.cells_of(point)[0]
        assert (np.abs(cell - coordinates) <= 0.5 + 1e-9).all()
        assert (cell >= 0).all()
        assert (cell < CELLS.shape).all()
    else:
        ends = r"from \[ 1.  -2.   0.5\] to \[ 1.3 -1.2  2. \]"
        refused(f"points: expected points in the grid, {ends}", CELLS.cells_of, point)


@given(
    hnp.arrays(float, st.tuples(st.integers(1, 9), st.integers(2, 3)), elements=st.floats(-9, 9)),
    st.floats(0.0, 2.0),
    st.floats(0.3, 2.0),
)
def test_a_covering_grid_reaches_the_margin_and_little_more(points, margin, spacing):
    grid = lt.Grid.covering(points, margin=margin, spacing=spacing)
    low, high = grid.origin, grid.points_at([np.array(grid.shape) - 1])[0]
    slack = 1e-9
    assert (low <= points.min(axis=0) - margin + slack).all()
    assert (high >= points.max(axis=0) + margin - slack).all()
    assert (low > points.min(axis=0) - margin - spacing - slack).all()
    assert (high < points.max(axis=0) + margin + spacing + slack).all()
    assert grid.contains(points).all()


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


GRID = lt.Grid((0.0, 0.0), 0.01, (100, 100))
WALL = lt.Box((0.2, 0.7, 1.0), (0.5, 0.3, 0.0))  # from the lower edge up to 0.65


def length(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()


def least_distance(path, walls):
    distance = distance_transform(walls, spacing=GRID.spacing)
    return distance[tuple(GRID.cells_of(path).T)].min()


def test_speed_grows_from_the_walls_to_one_at_the_area_of_influence():
    walls = occupied(GRID, [WALL])
    speed = fm2_speed(GRID, walls, area_of_influence=0.1)
    distance = distance_transform(walls, spacing=0.01)
    assert not speed[walls].any()
    assert (speed[distance >= 0.1 + 1e-12] == 1.0).all()
    between = (distance > 0) & (distance < 0.1)
    np.testing.assert_allclose(speed[between], distance[between] / 0.1, rtol=1e-12)


def test_saturation_is_a_share_of_the_largest_distance():
    walls = occupied(GRID, [WALL])
    deepest = distance_transform(walls, spacing=0.01).max()
    np.testing.assert_array_equal(
        fm2_speed(GRID, walls, saturation=0.25),
        fm2_speed(GRID, walls, area_of_influence=0.25 * deepest),
    )
    np.testing.assert_array_equal(fm2_speed(GRID, walls, saturation=0.0), np.where(walls, 0.0, 1.0))


def test_a_larger_area_of_influence_gives_longer_and_safer_paths():
    walls = occupied(GRID, [WALL])
    lengths, distances = [], []
    for saturation in (0.0, 0.1, 0.3, 1.0):
        speed = fm2_speed(GRID, walls, saturation=saturation)
        path = plan(speed, GRID, (0.2, 0.1), (0.8, 0.1)).path
        lengths.append(length(path))
        distances.append(least_distance(path[np.abs(path[:, 0] - 0.5) < 0.1], walls))
    assert (np.diff(lengths) > 0).all()
    assert (np.diff(distances) > 0).all()


def test_maps_without_walls_or_without_free_space_have_one_speed():
    assert (fm2_speed(GRID, np.zeros(GRID.shape, bool), saturation=0.5) == 1.0).all()
    assert not fm2_speed(GRID, np.ones(GRID.shape, bool), area_of_influence=0.5).any()


def test_a_plan_without_a_path_says_why():
    ring = np.zeros(GRID.shape, bool)
    ring[20:81, 20:81] = True
    ring[25:76, 25:76] = False
    speed = fm2_speed(GRID, ring, saturation=0.0)
    inside, outside, wall, beyond = (0.5, 0.5), (0.05, 0.05), (0.22, 0.5), (2.0, 0.5)
    for start, goal, reason in [
        (inside, outside, "goal_enclosed"),
        (outside, inside, "goal_enclosed"),
        (wall, inside, "start_in_wall"),
        (inside, wall, "goal_in_wall"),
        (beyond, inside, "start_outside"),
        (inside, beyond, "goal_outside"),
    ]:
        refused = plan(speed, GRID, start, goal)
        assert (refused.found, refused.reason) == (False, reason)
        assert refused.path.shape == (0, 2)
        assert refused.arrival_time == np.inf
    found = plan(speed, GRID, inside, (0.6, 0.6))
    assert (found.found, found.reason) == (True, "")
    assert found.arrival_time == pytest.approx(np.hypot(0.1, 0.1), rel=0.1)


def test_many_starts_have_the_plans_of_each():
    walls = occupied(GRID, [WALL])
    speed = fm2_speed(GRID, walls, area_of_influence=0.1)
    starts = [(0.2, 0.1), (0.5, 0.2), (3.0, 0.1), (0.9, 0.9)]
    plans = plan_many(speed, GRID, starts, (0.8, 0.1))
    assert [p.reason for p in plans] == ["", "start_in_wall", "start_outside", ""]
    for start, together in zip(starts, plans, strict=True):
        np.testing.assert_array_equal(together.path, plan(speed, GRID, start, (0.8, 0.1)).path)
    assert plan_many(speed, GRID, np.empty((0, 2)), (0.8, 0.1)) == []


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.integers(2, 3))
def test_paths_among_random_obstacles_touch_no_wall(seed, dimensions):
    rng = np.random.default_rng(seed)
    grid = lt.Grid(np.zeros(dimensions), 0.05, (20,) * dimensions)
    shapes = [lt.Box(rng.uniform(0.05, 0.4, 3), rng.uniform(0, 1, 3)) for _ in range(3)]
    shapes.append(lt.Sphere(rng.uniform(0.05, 0.2), rng.uniform(0, 1, 3)))
    shapes.append(lt.Capsule(0.05, 0.3, rng.uniform(0, 1, 3)))
    walls = occupied(grid, shapes)
    walls |= occupied_by_points(grid, rng.uniform(0, 1, (10, dimensions)), radius=0.05)
    speed = fm2_speed(grid, walls, saturation=rng.uniform())
    start, goal = rng.uniform(0, 0.95, (2, dimensions))
    found = plan(speed, grid, start, goal)
    if not found.found:
        return
    t = np.linspace(0.0, 1.0, 30)[:, None]
    dense = np.concatenate([a + t * (b - a) for a, b in itertools.pairwise(found.path)])
    assert not walls[tuple(grid.cells_of(dense).T)].any()
    np.testing.assert_array_equal(found.path[[0, -1]], [start, goal])
