import itertools

import numpy as np
import pytest
from refusals import raised

import leadthrough as lt
from leadthrough.errors import NoPath
from leadthrough.planning import descend, direction


def length(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()


def test_a_path_through_free_space_is_straight():
    grid = lt.Grid((0.0, 0.0), 1.0, (120, 130))
    times = lt.arrival_times(np.ones(grid.shape), (100, 90), order=2)
    start, goal = np.array([7.3, 11.8]), np.array([100.0, 90.0])
    path = descend(times, grid, start, goal)
    normal = np.array([-(goal - start)[1], (goal - start)[0]]) / np.linalg.norm(goal - start)
    assert np.abs((path - start) @ normal).max() < 0.1
    assert length(path) == pytest.approx(np.linalg.norm(goal - start), rel=1e-4)


def test_a_path_around_a_box_hugs_its_corner():
    grid = lt.Grid((0.0, 0.0), 0.01, (100, 100))
    speed = np.ones(grid.shape)
    speed[40:60, :70] = 0.0
    times = lt.arrival_times(speed, (80, 10), spacing=0.01)
    path = descend(times, grid, (0.2, 0.1), (0.8, 0.1))
    corners = np.array([(0.2, 0.1), (0.395, 0.695), (0.595, 0.695), (0.8, 0.1)])
    assert length(corners) - 1e-9 < length(path) < 1.02 * length(corners)


def test_arrival_falls_along_a_path_through_a_smooth_field():
    grid = lt.Grid((0.0, 0.0, 0.0), 1.0, (30, 30, 30))
    x, y, z = np.moveaxis(grid.centres(), -1, 0)
    speed = 0.6 + 0.4 * np.sin(0.3 * x) * np.cos(0.2 * y) * np.sin(0.25 * z + 1)
    times = lt.arrival_times(speed, (25, 24, 23), order=2)
    path = descend(times, grid, (2.2, 3.1, 1.7), (25, 24, 23))
    along = np.array([_interpolated(times, p) for p in path])
    assert (np.diff(along) < 0).all()
    # Along the quickest path, length over speed adds up to the arrival time.
    speeds = np.array([_interpolated(speed, p) for p in 0.5 * (path[1:] + path[:-1])])
    spent = np.sum(np.linalg.norm(np.diff(path, axis=0), axis=1) / speeds)
    assert spent == pytest.approx(along[0], rel=0.05)


def _interpolated(field, point):
    low = np.clip(np.floor(point).astype(int), 0, np.array(field.shape) - 2)
    x, y, z = point - low
    cube = field[tuple(slice(n, n + 2) for n in low)]
    return np.array([1 - x, x]) @ (cube @ [1 - z, z]) @ [1 - y, y]


def test_a_corridor_one_cell_wide_is_followed_to_its_end():
    speed = np.zeros((9, 9))
    speed[::2] = 1.0
    speed[1::4, 8] = speed[3::4, 0] = 1.0
    grid = lt.Grid((0.0, 0.0), 1.0, speed.shape)
    times = lt.arrival_times(speed, (8, 8))
    path = descend(times, grid, (0.0, 0.0), (8.0, 8.0))
    dense = np.concatenate([np.linspace(*ends, 50) for ends in itertools.pairwise(path)])
    assert np.isfinite(times[tuple(grid.cells_of(dense).T)]).all()
    assert length(path) > 40.0


def test_a_start_at_the_goal_is_the_whole_path():
    grid = lt.Grid((0.0, 0.0), 1.0, (5, 5))
    times = lt.arrival_times(np.ones((5, 5)), (2, 2))
    np.testing.assert_array_equal(descend(times, grid, (2.0, 2.0), (2.0, 2.0)), [[2.0, 2.0]])


def test_no_path_says_why(divided):
    grid, times = divided.grid, divided.times
    for start, reason in divided.pathless.items():
        assert raised(NoPath, descend, times, grid, start, (0.0, 0.0)).reason == reason
    both = lt.arrival_times(divided.speed, [(0, 0), (2, 6)])
    assert raised(NoPath, descend, both, grid, (1.0, 5.0), (0.0, 0.0)).reason == "other_source"


def test_in_free_space_directions_point_to_the_source():
    grid = lt.Grid((-1.0, 2.0), (0.1, 0.2), (60, 50))
    times = lt.arrival_times(np.ones(grid.shape), (20, 30), spacing=grid.spacing, order=2)
    goal = grid.points_at([(20.0, 30.0)])[0]
    points = grid.points_at(np.random.default_rng(1).uniform(0, np.array(grid.shape) - 1, (300, 2)))
    towards = (goal - points) / np.linalg.norm(goal - points, axis=1, keepdims=True)
    cosines = (direction(times, grid, points) * towards).sum(axis=1)
    assert np.quantile(cosines, 0.05) > 0.995
    assert cosines.min() > 0.8


def test_where_fronts_meet_there_is_a_direction_all_the_same():
    grid = lt.Grid((0.0, 0.0), 1.0, (21, 9))
    times = lt.arrival_times(np.ones(grid.shape), [(0, 4), (20, 4)])
    vectors = direction(times, grid, [(10.0, 4.0), (9.5, 4.0), (10.0, 4.3)])
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0)


def test_no_positions_have_no_directions():
    grid = lt.Grid((0.0, 0.0), 1.0, (5, 5))
    assert direction(np.zeros((5, 5)), grid, np.empty((0, 2))).shape == (0, 2)


def test_positions_without_a_direction_say_why(divided):
    for point, reason in divided.pathless.items():
        caught = raised(NoPath, direction, divided.times, divided.grid, [(1.0, 1.0), point])
        assert caught.reason == reason
        assert "positions[1]" in str(caught)
