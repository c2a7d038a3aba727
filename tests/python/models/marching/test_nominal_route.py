"""A query whose ends are moved a little keeps the way of the usual motion, or the route says so."""

import numpy as np
import pytest
from models.marching.paths import apart, arcs, size_of

import leadthrough as lt
from leadthrough.preprocess.resample import by_arc_length

OFFSETS = (0.01, 0.03, 0.1, 0.3)  # of the demonstrations' size
DIRECTIONS = np.deg2rad([20.0, 140.0, 260.0])


def moves(size, angles=DIRECTIONS):
    for offset in OFFSETS:
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
        if found.method == usual.method:
            assert apart(usual.path, found.path) <= 1.5 * offset + skill.area_of_influence


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
            region = np.concatenate([*skill.experience, found.path[[0, -1]]])
            low, high = region.min(axis=0), region.max(axis=0)
            assert np.maximum(low - found.path, found.path - high).max() <= offset
