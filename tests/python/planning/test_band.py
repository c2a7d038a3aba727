from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import NoPath
from leadthrough.planning import Grid, arrival_times, descend
from leadthrough.planning.obstacles import Walls
from leadthrough.planning.speed_map import MapField, ObstacleField, TubeField, quickest, speeds_at
from leadthrough.preprocess.curve_distance import frechet_distance
from leadthrough.preprocess.resample import by_arc_length


def in_whole_map(field, start, goal):
    """The same path by a march through all cells."""
    grid = field.grid
    speed = field.at(np.arange(np.prod(grid.shape))).reshape(grid.shape)
    first, source = grid.cells_of(np.stack([start, goal]))
    arrival = arrival_times(speed, source, spacing=grid.spacing, order=2, stop=first)
    return descend(arrival, grid, start, goal)


def random_scene(seed):
    rng = np.random.default_rng(seed)
    dimensions = 2 + seed % 2
    u = np.linspace(0.0, 1.0, 200)[:, None]
    waves = rng.normal(0.0, 1.0, (3, dimensions)) * [[0.15], [0.08], [0.05]]
    path = u * rng.uniform(0.2, 0.5, dimensions)
    path = path + sum(wave * np.sin(np.pi * k * u) for k, wave in enumerate(waves, 1))
    places = np.zeros((3, 3))
    places[:, :dimensions] = path[rng.integers(40, 160, 3)] + rng.normal(0, 0.02, dimensions)
    obstacles = [
        lt.Box(rng.uniform(0.02, 0.1, 3), places[0], (np.cos(seed), 0, 0, np.sin(seed))),
        lt.Sphere(rng.uniform(0.02, 0.05), places[1]),
        lt.Cylinder(rng.uniform(0.01, 0.04), 0.1, places[2]),
    ]
    grid = Grid.covering(path, margin=0.15, spacing=0.004 if dimensions == 2 else 0.009)
    radius = rng.choice([0.02, 0.15])
    free = TubeField(grid, [path], [1.0], area_of_influence=radius, saturation=0.02)
    return ObstacleField(free, Walls(grid, obstacles), area_of_influence=0.015), path


@pytest.mark.parametrize("seed", range(8))
def test_path_is_that_of_a_march_through_the_whole_map(seed):
    field, path = random_scene(seed)
    found = quickest(field, path[0], path[-1])
    whole = in_whole_map(field, path[0], path[-1])
    even = (by_arc_length(each, 2000) for each in (found, whole))
    assert frechet_distance(*even) <= 0.5 * field.grid.spacing.max()
    np.testing.assert_array_equal(found[[0, -1]], path[[0, -1]])
    along = by_arc_length(found, 20 * len(found))
    assert speeds_at(field, field.grid.cells_of(along)).all()


def wall_with_gap(width):
    """A wall of two cells across the straight way, with a gap far from it."""
    speed = np.ones((200, 160))
    speed[100:102] = 0.0
    speed[100:102, 130 : 130 + width] = 1.0
    return MapField(Grid((0.0, 0.0), 1.0, speed.shape), speed)


@pytest.mark.parametrize("width", [1, 3])
def test_gap_in_a_wall_thinner_than_a_block_is_found(width):
    field, start, goal = wall_with_gap(width), np.array([10.0, 20.0]), np.array([190.0, 25.0])
    even = (by_arc_length(each(field, start, goal), 4000) for each in (quickest, in_whole_map))
    assert frechet_distance(*even) <= 0.5


def test_walls_between_the_ends_leave_no_path():
    start, goal = np.array([10.0, 20.0]), np.array([190.0, 25.0])
    with pytest.raises(NoPath, match="separate") as error:
        quickest(wall_with_gap(0), start, goal)
    assert error.value.reason == "goal_enclosed"


@pytest.mark.parametrize("end", ["start", "goal"])
def test_end_in_a_wall_is_no_path(end):
    ends = {"start": np.array([10.0, 20.0]), "goal": np.array([190.0, 25.0])}
    ends[end] = np.array([100.0, 20.0])
    with pytest.raises(NoPath, match=end) as error:
        quickest(wall_with_gap(3), **ends)
    assert error.value.reason == f"{end}_in_wall"


def test_start_at_the_goal_is_a_path_of_one_place():
    field = wall_with_gap(3)
    place = np.array([10.2, 20.1])
    path = quickest(field, place, place)
    np.testing.assert_array_equal(path, np.broadcast_to(place, path.shape))


def test_threads_find_the_same_bits():
    field, path = random_scene(3)
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda _: quickest(field, path[0], path[-1]), range(4)))
    for each in found[1:]:
        np.testing.assert_array_equal(each, found[0])
