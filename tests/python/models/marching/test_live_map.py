"""Routes in a map that is kept for a workspace."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import leadthrough as lt

WORKSPACE = ((-0.1, -0.5, -0.1), (0.7, 0.5, 0.6))
START, GOAL = np.array([0.1, -0.3, 0.1]), np.array([0.5, 0.3, 0.1])


@pytest.fixture(scope="module")
def skill():
    rng = np.random.default_rng(2)
    share = np.linspace(0.0, 1.0, 120)
    shown = []
    for _ in range(4):
        path = START + np.outer(share, GOAL - START) + rng.normal(0.0, 0.005, 3)
        path[:, 2] += 0.2 * np.sin(np.pi * share)
        shown.append(lt.Demonstration(lt.Trajectory(2.0 * share, path)))
    return lt.FastMarching(method="map", resolution=0.01, workspace=WORKSPACE).fit(shown)


@pytest.fixture(scope="module")
def live(skill):
    return skill.live_map(WORKSPACE, cells=560_000)


def test_map_has_about_the_cells_asked_for(live):
    assert np.prod(live.grid.shape) == pytest.approx(560_000, rel=0.1)


@pytest.mark.parametrize("obstacles", [(), (lt.Box((0.1, 0.1, 0.2), (0.3, 0.0, 0.3)),)])
def test_route_is_the_one_of_the_skill(obstacles, skill, live):
    wanted = skill.plan(start=START, goal=GOAL, obstacles=obstacles)
    found = live.route(START, GOAL, obstacles)
    # First order against second: they agree to a cell or two.
    assert cKDTree(wanted.path).query(found.path)[0].max() < 0.025
    assert np.array_equal(found.path[[0, -1]], [START, GOAL])


def test_moved_obstacle_is_the_only_one_that_counts(live):
    here, there = (lt.Sphere(0.08, (0.3, y, 0.3)) for y in (0.0, 0.2))
    live.route(START, GOAL, [here])
    path = live.route(START, GOAL, [there]).path
    assert there.distance(path).min() > 0.0
    assert np.array_equal(path, live.route(START, GOAL, [there]).path)


def test_route_becomes_a_motion(skill, live):
    motion = skill.in_time(live.route(START, GOAL, ()), duration=3.0, dt=0.05)
    assert motion.duration == pytest.approx(3.0)
    assert np.allclose(motion.positions[-1], GOAL)
