"""Speed fields, and the quickest path in a band of their cells."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.spatial import cKDTree

import leadthrough as lt
from leadthrough.planning import Grid, arrival_times, descend, speed_map
from leadthrough.planning.speed_map import (
    DetourField,
    ExperienceField,
    MapField,
    ObstacleField,
    SaturatedField,
    TubeField,
    Walls,
    add_passable_obstacles,
    quickest,
    speeds_at,
)
from leadthrough.preprocess import by_arc_length, frechet_distance

SATURATION, RADIUS, REACH = 0.05, 0.063, 0.087


def grid_and_paths(dimensions):
    rng = np.random.default_rng(dimensions)
    u = np.linspace(0.0, 1.0, 60)[:, None]
    paths = [
        (1 - u) * a + u * b + 0.1 * np.sin(np.pi * u) * c
        for a, b, c in rng.uniform(0.0, 0.5, (3, 3, dimensions))
    ]
    spacing = [0.013, 0.011, 0.017][:dimensions]
    return Grid.covering(np.concatenate(paths), margin=0.1, spacing=spacing), paths


def tube_map(grid, paths, weights, *, area_of_influence, saturation):
    """The whole map of a `TubeField`: in the overlap of tubes the faster one counts."""
    speed = np.full(grid.shape, saturation)
    centres = grid.centres()
    for path, weight in zip(paths, weights, strict=True):
        distance, _ = cKDTree(speed_map.fine_samples(path, grid)).query(centres)
        closeness = weight * np.maximum(1.0 - distance / area_of_influence, 0.0)
        speed = np.maximum(speed, saturation + (1.0 - saturation) * closeness)
    return speed


def obstacles_on(path):
    places = np.zeros((3, 3))
    places[:, : path.shape[1]] = path[[10, 30, 45]]
    return [
        lt.Box((0.1, 0.05, 0.08), places[0], (0.8, 0.0, 0.0, 0.6)),
        lt.Sphere(0.03, places[1]),
        lt.Capsule(0.02, 0.2, places[2] + 0.02),
    ]


def free_fields(grid, paths):
    sizes = {"area_of_influence": RADIUS, "saturation": SATURATION}
    weights = [1.0, 0.3, 0.8]
    yield ExperienceField(grid, paths, **sizes), speed_map.experience_map(grid, paths, **sizes)
    tubes = (grid, paths, weights)
    yield TubeField(*tubes, **sizes), tube_map(*tubes, **sizes)


def fields(dimensions):
    """Every kind of field, with the same map as a whole."""
    grid, paths = grid_and_paths(dimensions)
    obstacles = obstacles_on(paths[0])
    walls = Walls(grid, obstacles)
    for free, map_ in free_fields(grid, paths):
        yield free, map_
        yield MapField(grid, map_), map_
        yield (
            ObstacleField(free, walls, area_of_influence=REACH),
            speed_map.add_obstacles(map_, grid, obstacles, area_of_influence=REACH),
        )
        saturated = {"area_of_influence": REACH, "saturation": 0.3}
        yield (
            SaturatedField(free, walls, **saturated),
            speed_map.add_saturated_obstacles(map_, grid, obstacles, **saturated),
        )
        ways = {"band": REACH / 2, "reach": 0.17}
        yield (
            DetourField(free, walls, **ways),
            speed_map.add_passable_obstacles(map_, grid, obstacles, saturation=SATURATION, **ways),
        )


@pytest.mark.parametrize("dimensions", [2, 3])
def test_speeds_are_those_of_the_whole_map(dimensions):
    for field, map_ in fields(dimensions):
        whole = field.at(np.arange(map_.size))
        np.testing.assert_allclose(whole, map_.ravel(), rtol=1e-12, atol=1e-15)
        assert ((whole == 0.0) == (map_.ravel() == 0.0)).all()
        some = np.flatnonzero(np.random.default_rng(1).random(map_.size) < 0.02)
        np.testing.assert_array_equal(field.at(some), whole[some])
        cells = np.argwhere(map_ > -1.0)[some[::-1]]
        np.testing.assert_array_equal(speeds_at(field, cells), whole[some[::-1]])


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("level", [0, 1, 3])
def test_no_cell_of_a_block_is_faster_than_its_bound(dimensions, level):
    for field, map_ in fields(dimensions):
        largest = map_
        for axis, count in enumerate(map_.shape):
            largest = np.maximum.reduceat(largest, np.arange(0, count, 2**level), axis=axis)
        bounds = field.fastest(level, np.arange(largest.size))
        assert (bounds >= largest.ravel() * (1.0 - 1e-12)).all()


def test_without_experience_the_wave_is_slow_everywhere_and_with_nothing_else_fast():
    grid = Grid((0.0, 0.0), 0.1, (20, 30))
    sizes = {"area_of_influence": 9.0, "saturation": 0.2}
    some = np.arange(0, 600, 7)
    assert (ExperienceField(grid, [], **sizes).at(some) == 0.2).all()
    assert (ExperienceField(grid, [np.ones((2, 2))], **sizes).at(some) == 1.0).all()


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


def test_threads_find_the_same_bits():
    field, path = random_scene(3)
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda _: quickest(field, path[0], path[-1]), range(4)))
    for each in found[1:]:
        np.testing.assert_array_equal(each, found[0])


@pytest.mark.parametrize(("height", "in_the_tube"), [(0.0, True), (0.28, False)])
def test_ways_round_lead_only_where_an_obstacle_stands_in_a_tube(height, in_the_tube):
    grid = lt.Grid((-0.5, -0.5), 0.02, (51, 51))
    speed = np.full(grid.shape, 0.1)
    speed[:, 23:28] = 1.0  # a tube along x, 0.05 m to either side
    ball = [lt.Sphere(0.15, (0.0, height, 0.0))]
    found = add_passable_obstacles(speed, grid, ball, band=0.1, saturation=0.1, reach=0.2)
    assert (found > speed).any() == in_the_tube
