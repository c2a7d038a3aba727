"""Resemblance and direction of demonstrations, start barriers, maps of far ends."""

from itertools import pairwise

import numpy as np
import pytest
from models.marching.paths import apart
from models.marching.test_moved_ends import away, shown

import leadthrough as lt
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.planner import directed, resemble_another
from leadthrough.models.marching.policy import start_barrier
from leadthrough.models.marching.route import Query
from leadthrough.planning import Grid, maps
from leadthrough.planning.maps import Scales

ANGLE = np.linspace(0.0, 2.0 * np.pi, 200)


def experience(path):
    return Experience(path, duration=2.0, progress=np.linspace(0.0, 1.0, 1001))


def arc(height):
    return np.column_stack([0.5 - 0.5 * np.cos(ANGLE / 2.0), height * np.sin(ANGLE / 2.0)])


def test_two_arcs_of_one_branch_resemble_each_other_and_a_third_none():
    paths = [arc(0.5), arc(-0.45), arc(0.52)]
    np.testing.assert_array_equal(resemble_another(paths), [True, False, True])
    for scale in (1e-3, 1e3):  # whatever the unit
        np.testing.assert_array_equal(
            resemble_another([scale * p for p in paths]), [True, False, True]
        )


@pytest.mark.parametrize("position", [(0.0, 0.0), (3.0, -2.0), (0.0, 40.0)])
def test_a_ring_has_a_barrier_square_to_its_path_at_every_position(position):
    goal = np.array(position)
    ring = goal + 0.2 * np.column_stack([1.0 - np.cos(ANGLE), np.sin(ANGLE)])
    grid = Grid.covering(ring, margin=0.1, spacing=0.005)
    scales = Scales(radius=0.02, clearance=0.02, saturation=0.1, resolution=0.005)
    barrier = start_barrier([experience(ring)], goal, grid, scales)
    np.testing.assert_allclose(barrier.normal, (0.0, 1.0), atol=1e-3)
    np.testing.assert_allclose(barrier.middle - goal, (0.0, -0.01), atol=1e-4)
    np.testing.assert_allclose(barrier.goal - goal, (0.0, -0.02), atol=1e-4)
    assert start_barrier([experience(ring)], ring[60], grid, scales) is None


@pytest.mark.parametrize(("gap", "kept"), [(0.3, True), (0.5, False)])
def test_a_stroke_that_ends_beside_its_start_is_not_turned_around_by_a_small_move(gap, kept):
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.6], [0.0, gap]])
    stroke = np.concatenate([np.linspace(*ends, 60) for ends in pairwise(corners)])
    known = [experience(stroke), experience(np.add(stroke, (0.002, 0.001)))]
    backwards = Query(stroke[-1], stroke[0])
    assert not any(each.towards(*backwards.ends) is each for each in known)
    assert all(
        (one is other) == kept for one, other in zip(directed(known, backwards), known, strict=True)
    )


@pytest.mark.parametrize(("apart", "turned"), [(0.075, True), (0.04, False)])
def test_a_motion_that_nearly_returns_is_turned_round_only_for_ends_clearly_apart(apart, turned):
    angle = np.linspace(0.0, 1.0, 400) * (2.0 * np.pi - 2.0 * np.arcsin(np.pi * apart))
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) / (2.0 * np.pi)  # about 1 round
    found = experience(ring).towards(ring[-1], ring[0])
    assert np.array_equal(found.path[0], ring[-1 if turned else 0])


def planned_in_one_map(skill, monkeypatch, **query):
    with monkeypatch.context() as patch:
        patch.setattr(maps, "_FAR", np.inf)
        return skill.plan(**query)


@pytest.mark.parametrize("end", ["start", "goal"])
@pytest.mark.parametrize("angle", [0.0, 2.1, 3.5])
def test_way_from_afar_is_that_of_a_map_of_everything(end, angle, monkeypatch):
    skill = lt.FastMarching(resolution=0.004, method="map").fit(shown(2))
    query = {end: away(angle, 2.0)}
    route = skill.plan(**query)
    whole = planned_in_one_map(skill, monkeypatch, **query)
    assert route.travel_time == pytest.approx(whole.travel_time, rel=2e-3)
    assert apart(route.path, whole.path, 3000) < 2.0 * 0.004
