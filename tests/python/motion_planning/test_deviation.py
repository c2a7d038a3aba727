"""Deviation allowed from the path of the tip: as stated, or as far as the demonstrations spread."""

import numpy as np
import pytest
from motion_planning.conftest import across

import leadthrough as lt
from leadthrough.errors import InvalidInput

QUERY = lt.Query(dt=0.025)


@pytest.fixture(scope="module")
def skill():
    """Reaches across the table, higher or lower in the middle by 4 cm, the tool pointing down."""
    bows = ((-0.002, -0.04), (0.0, 0.0), (0.002, 0.04), (0.001, -0.02), (-0.001, 0.02))
    shown = [across(side, 0.02 + height, width=0.5, low=0.33) for side, height in bows]
    return lt.ProMP(weights=8).fit(shown)


@pytest.fixture(scope="module")
def post():
    return lt.Box([0.06, 0.06, 0.2], [0.45, 0.0, 0.255])


def test_the_tip_stays_within_the_skills_own_spread(panda, skill, post):
    planned = lt.plan_motion(skill, panda, [post], QUERY, standard_deviations=2.5)
    assert panda.check(planned.joints, [post]).ok
    assert planned.rounds == 2
    assert "obstacle 0" in planned.reasons[0]
    found, _ = panda.forward_kinematics(planned.joints.positions)
    np.testing.assert_allclose(found, planned.tip.positions, atol=1e-9)
    alone = skill.generate(dt=0.025)
    away = found - alone.positions
    assert np.abs(away[[0, -1]]).max() < 1e-5
    assert 0.01 < np.abs(away[:, 2]).max() < 0.1
    _, covariance = skill.distribution(planned.tip.times)
    inside = slice(1, -1)
    scaled = np.linalg.solve(covariance[inside, :3, :3], away[inside, :, None])
    assert np.sqrt(np.einsum("ni,nik->n", away[inside], scaled)).max() < 2.6
    assert planned.deviation <= np.linalg.norm(away, axis=1).max() + 1e-9


def test_the_tip_stays_within_what_is_stated(panda, skill, post):
    planned = lt.plan_motion(skill, panda, [post], QUERY, deviation=(0.06, 0.0))
    assert panda.check(planned.joints, [post]).ok
    assert 0.01 < planned.deviation < 0.06
    assert planned.tip.times[-1] == skill.generate(dt=0.025).times[-1]


def test_where_that_is_not_enough_another_path_is_made(panda, skill, post):
    planned = lt.plan_motion(skill, panda, [post], QUERY, deviation=(0.005, 0.0))
    assert panda.check(planned.joints, [post]).ok
    assert planned.deviation > 0.01


def test_a_skill_without_a_covariance_is_refused(panda, skill):
    shown = lt.Demonstration(skill.generate(dt=0.05))
    for other in (lt.DMP().fit([shown]), lt.ProMP().fit([panda.follow(shown.motion)])):
        with pytest.raises(InvalidInput, match="standard_deviations: this skill has no covariance"):
            lt.plan_motion(other, panda, standard_deviations=2.0)
    with pytest.raises(InvalidInput, match="standard_deviations"):
        lt.plan_motion(skill, panda, standard_deviations=0.0)
    with pytest.raises(InvalidInput, match="deviation: not used together with standard_deviations"):
        lt.plan_motion(skill, panda, standard_deviations=2.0, deviation=(0.1, 0.0))
