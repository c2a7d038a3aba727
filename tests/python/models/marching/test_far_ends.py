import numpy as np
import pytest
from models.marching.paths import gaps_to

import leadthrough as lt
from leadthrough.errors import NoPath
from leadthrough.preprocess.resample import by_arc_length

MIDDLE = np.array([40.0, 0.3])  # so far from the origin that a place a kilometre away is no slip


def shown(dimensions):
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 3.0, 200)
    s = (t / 3.0) ** 2 * (3.0 - 2.0 * t / 3.0)
    path = np.column_stack([0.5 * s - 0.25, 0.12 * np.sin(np.pi * s), 0.1 * s])[:, :dimensions]
    path[:, :2] += MIDDLE
    return [
        lt.Demonstration(lt.Trajectory(t, path + rng.normal(0.0, 0.005, dimensions)))
        for _ in range(5)
    ]


def away(angle, distance):
    return MIDDLE + distance * np.array([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.6, 2.9, 4.1])
def test_start_a_thousand_lengths_away_leads_straight_to_the_demonstrations(angle):
    start = away(angle, 600.0)
    route = lt.FastMarching().fit(shown(2)).plan(start=start)
    np.testing.assert_array_equal(route.path[0], start)
    assert np.linalg.norm(route.path[-1] - MIDDLE - [0.25, 0.0]) < 0.01
    assert route.length < 600.8
    outside = route.path[np.linalg.norm(route.path - MIDDLE, axis=1) > 1.0]
    directions = np.diff(outside, axis=0)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    assert (directions @ directions[0]).min() > 1.0 - 1e-9


def test_obstacle_between_a_far_start_and_the_demonstrations_is_passed():
    skill = lt.FastMarching().fit(shown(3))
    start = np.array([*away(2.5, 4.0), 0.0])
    box = lt.Box((0.5, 0.5, 0.5), 0.5 * (start + np.array([*MIDDLE, 0.05])))
    free, around = skill.plan(start=start), skill.plan(start=start, obstacles=[box])
    assert box.distance(by_arc_length(free.path, 5000)).min() < 0.0
    assert box.distance(by_arc_length(around.path, 5000)).min() > 0.0
    assert around.length < 1.1 * free.length


def test_obstacle_on_the_shown_way_is_passed_from_afar():
    skill = lt.FastMarching().fit(shown(3))
    start = np.array([*away(3.3, 5.0), 0.3])
    middle = skill.generate().positions[150]
    box = lt.Box((0.06, 0.06, 0.3), middle)
    path = skill.plan(start=start, obstacles=[box]).path
    assert box.distance(by_arc_length(path, 9000)).min() > 0.0


def test_far_start_in_an_obstacle_is_no_path():
    start = np.array([*away(0.3, 4.0), 0.0])
    with pytest.raises(NoPath, match="start") as error:
        lt.FastMarching().fit(shown(3)).plan(start=start, obstacles=[lt.Sphere(0.2, start)])
    assert error.value.reason == "start_in_wall"


def test_motion_from_afar_has_the_shape_of_the_demonstrations_at_its_end():
    skill = lt.FastMarching().fit(shown(2))
    motion = skill.generate(start=away(3.0, 100.0), dt=0.001)
    usual = skill.generate().positions
    end = motion.positions[np.linalg.norm(motion.positions - MIDDLE, axis=1) < 0.15]
    gaps = gaps_to(usual, end)
    assert gaps.max() < 0.01
