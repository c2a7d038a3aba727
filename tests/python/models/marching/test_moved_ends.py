"""Moved starts and goals, near and far, another pace, one wrong sample: bounded changes."""

import numpy as np
import pytest
from models.marching.paths import apart, arcs, assert_bounded, gaps_to, lead_out, size_of
from motions import minimum_jerk

import leadthrough as lt
from leadthrough.errors import NoPath
from leadthrough.preprocess import by_arc_length

OFFSETS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # of the demonstrations' size
DIRECTIONS = np.deg2rad([20.0, 140.0, 260.0])
SHARE = np.linspace(0.0, 1.0, 120)
RISE = minimum_jerk(SHARE)


def family(seed, count, *, closed=False, slower=1.0):
    """Curves of one kind in the plane, with scattered ends; closed ones return to their start."""
    rng = np.random.default_rng(seed)
    bends, ends = rng.normal(0.0, 0.15, (4, 2)), rng.normal(0.0, 0.3, (2, 2))
    waves = np.stack([np.sin(np.pi * (k + 1) * RISE) for k in range(4)], axis=1)
    made = []
    for _ in range(count):
        own, (first, last) = (
            values + rng.normal(0.0, 0.02, values.shape) for values in (bends, ends)
        )
        last = first + rng.normal(0.0, 0.01, 2) if closed else last
        points = first + np.outer(RISE, last - first) + waves @ own
        made.append(lt.Trajectory(slower * (1.5 + 0.2 * rng.random()) * SHARE, points))
    return made


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("count", [2, 5, 40])
@pytest.mark.parametrize("seed", [0, 1])
def test_moved_ends_move_the_motion_in_proportion(seed, count, closed):
    skill = lt.FastMarching().fit(family(seed, count, closed=closed))
    usual, query, size = skill.plan(), skill.query(), size_of(skill)
    for index, offset in enumerate(OFFSETS):
        angle = DIRECTIONS[index % 3]
        move = offset * size * np.array([np.cos(angle), np.sin(angle)])
        for start, goal in ((move, 0.0), (0.0, move), (move, move)):
            found = skill.plan(start=query.start + start, goal=query.goal + goal)
            assert_bounded(skill, usual, found, offset * size)


def test_ends_moved_past_each_other_do_not_turn_the_motion_around():
    """Reversed demonstrations, whose ends fitted better, moved the motion by 2.06 times as much."""
    skill = lt.FastMarching().fit(family(6, 40))
    usual, query, size = skill.plan(), skill.query(), size_of(skill)
    for angle in np.deg2rad(np.arange(0.0, 360.0, 30.0)):
        move = 0.3 * size * np.array([np.cos(angle), np.sin(angle)])
        found = skill.plan(start=query.start + move, goal=query.goal - move)
        assert_bounded(skill, usual, found, 0.3 * size)


def moves(size, angles=DIRECTIONS):
    for offset in OFFSETS[:4]:
        for angle in angles:
            move = offset * size * np.array([np.cos(angle), np.sin(angle)])
            for start, goal in ((move, 0.0 * move), (0.0 * move, move), (move, move)):
                yield offset * size, start, goal


@pytest.mark.parametrize("method", ["auto", "map", "start", "mean_path"])
@pytest.mark.parametrize("name", ["Multi_Models_1", "Multi_Models_3"])
def test_of_several_ways_a_moved_query_keeps_the_usual_one(name, method):
    """Start and goal by "map" jumped by up to 35.6 times the offset from one way to another."""
    skill = lt.FastMarching(method=method).fit(lt.io.lasa.load(name))
    usual, query = skill.plan(), skill.query()
    for offset, start, goal in moves(size_of(skill)):
        found = skill.plan(start=query.start + start, goal=query.goal + goal)
        assert not found.leaves_nominal_route
        assert_bounded(skill, usual, found, offset)


@pytest.mark.parametrize("name", ["Line", "BendedLine", "Leaf_1"])
def test_in_the_papers_map_a_moved_query_keeps_to_the_nominal_route(name):
    """Short cuts through the map of one way deviated by up to 14.6 times the offset."""
    shown = lt.io.lasa.load(name)
    skill = lt.FastMarching(method="map").fit([shown[i] for i in (0, 2, 6)])
    usual, query = skill.plan(), skill.query()
    for offset, start, goal in moves(size_of(skill)):
        found = skill.plan(start=query.start + start, goal=query.goal + goal)
        if not found.leaves_nominal_route:
            assert apart(usual.path, found.path) <= 1.5 * offset + skill.area_of_influence


def test_ways_from_one_start_are_not_changed_by_a_small_move():
    skill = lt.FastMarching().fit(arcs([0.2, -0.2]))
    usual, query = skill.plan(), skill.query()
    for angle in np.deg2rad(np.arange(0.0, 360.0, 30.0)):
        start = query.start + 0.012 * np.array([np.cos(angle), np.sin(angle)])
        found = skill.plan(start=start)
        assert found.method == usual.method == "mean_path"
        assert apart(usual.path, found.path) <= 1.5 * 0.012 + skill.area_of_influence


@pytest.mark.parametrize("method", ["auto", "map"])
def test_the_way_of_a_demonstration_is_taken_from_its_own_ends_and_the_route_says_so(method):
    shown = arcs([0.2, -0.2], gap=0.06)
    skill = lt.FastMarching(method=method).fit(shown)
    usual = skill.plan()
    changed = []
    for each in shown:
        found = skill.plan(start=each.positions[0], goal=each.positions[-1])
        middle = np.sign(each.positions[75, 1])
        assert np.sign(by_arc_length(found.path, 200)[100, 1]) == middle
        changed.append(found.leaves_nominal_route)
        bound = 1.5 * np.linalg.norm(found.path[0] - usual.path[0]) + skill.area_of_influence
        assert found.leaves_nominal_route or apart(usual.path, found.path) <= bound
    assert sum(changed) == 3


def test_an_obstacle_on_the_nominal_route_leads_to_another_one_and_the_route_says_so():
    skill = lt.FastMarching().fit(arcs([0.2, -0.2]))
    usual, query = skill.plan(), skill.query()
    side = np.sign(usual.path[len(usual.path) // 2, 1])
    box = lt.Box((0.06, 0.12, 0.1), (0.25, 0.2 * side, 0.0))
    around = skill.plan(start=query.start + 0.01, obstacles=[box])
    assert around.leaves_nominal_route
    assert np.sign(around.path[len(around.path) // 2, 1]) == -side
    aside = lt.Box((0.02, 0.02, 0.1), (0.25, -0.2 * side, 0.0))
    kept = skill.plan(start=query.start + 0.01, obstacles=[aside])
    assert not kept.leaves_nominal_route
    assert np.sign(kept.path[len(kept.path) // 2, 1]) == side


@pytest.mark.parametrize("name", ["Leaf_2", "BendedLine", "DoubleBendedLine", "GShape"])
def test_scattered_ends_lead_out_of_the_region_by_no_more_than_they_are_moved(name):
    """Smoothing led out of it by up to 1.07 times the offset."""
    rng = np.random.default_rng(14)
    shown = lt.io.lasa.load(name)
    skills = [
        lt.FastMarching(method=method).fit(shown[:count])
        for method in ("auto", "map")
        for count in (3, 7)
    ]
    for skill in skills:
        query, size = skill.query(), size_of(skill)
        for _ in range(20):
            offset = size * np.exp(rng.uniform(np.log(0.03), 0.0))
            move = rng.normal(size=(2, 2))
            move *= offset / np.linalg.norm(move, axis=1)[:, None]
            found = skill.plan(start=query.start + move[0], goal=query.goal + move[1])
            assert lead_out(skill, found.path) <= offset


FAR_MIDDLE = np.array(
    [40.0, 0.3]
)  # so far from the origin that a place a kilometre away is no slip


def shown(dimensions):
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 3.0, 200)
    s = (t / 3.0) ** 2 * (3.0 - 2.0 * t / 3.0)
    path = np.column_stack([0.5 * s - 0.25, 0.12 * np.sin(np.pi * s), 0.1 * s])[:, :dimensions]
    path[:, :2] += FAR_MIDDLE
    return [
        lt.Demonstration(lt.Trajectory(t, path + rng.normal(0.0, 0.005, dimensions)))
        for _ in range(5)
    ]


def away(angle, distance):
    return FAR_MIDDLE + distance * np.array([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.6, 2.9, 4.1])
def test_start_a_thousand_lengths_away_leads_straight_to_the_demonstrations(angle):
    start = away(angle, 600.0)
    route = lt.FastMarching().fit(shown(2)).plan(start=start)
    np.testing.assert_array_equal(route.path[0], start)
    assert np.linalg.norm(route.path[-1] - FAR_MIDDLE - [0.25, 0.0]) < 0.01
    assert route.length < 600.8
    outside = route.path[np.linalg.norm(route.path - FAR_MIDDLE, axis=1) > 1.0]
    directions = np.diff(outside, axis=0)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    assert (directions @ directions[0]).min() > 1.0 - 1e-9


def test_obstacle_between_a_far_start_and_the_demonstrations_is_passed():
    skill = lt.FastMarching().fit(shown(3))
    start = np.array([*away(2.5, 4.0), 0.0])
    box = lt.Box((0.5, 0.5, 0.5), 0.5 * (start + np.array([*FAR_MIDDLE, 0.05])))
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
    end = motion.positions[np.linalg.norm(motion.positions - FAR_MIDDLE, axis=1) < 0.15]
    gaps = gaps_to(usual, end)
    assert gaps.max() < 0.01
