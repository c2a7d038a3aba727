"""The map for an end far away gives the path of one map of everything."""

import numpy as np
import pytest
from models.marching.paths import apart
from models.marching.test_far_ends import away, shown

import leadthrough as lt
from leadthrough.models.marching import maps


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
