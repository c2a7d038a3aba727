"""Through joint space where no path of the tip leaves the arm room, by OMPL's RRT-Connect."""

import numpy as np
import pytest
from motion_planning.conftest import DOWN, across
from refusals import refused

import leadthrough as lt
from leadthrough.errors import IkFailure, MissingDependency
from leadthrough.motion_planning import connect_configurations, connection

QUERY = lt.Query(dt=0.02)
ONCE = {"query": QUERY, "rounds": 1}
LAST_RESORT = ONCE | {"last_resort": "joint_space"}


@pytest.fixture(scope="module")
def skill():
    """Of a reach with the gripper closed on the way."""
    return lt.DMP().fit([across(events=[lt.Event(1.0, "close")])])


@pytest.fixture(scope="module")
def planned(panda, skill, box):
    pytest.importorskip("ompl")
    return lt.plan_motion(skill, panda, [box], **LAST_RESORT)


def test_the_dead_part_is_connected_and_certified(panda, box, planned):
    report = panda.check(planned.joints, [box])
    assert report.ok
    assert planned.clearance == report.obstacles.minimum_distance
    used = panda.path_report(planned.joints, planned.tip)
    assert used.velocity_ratio.max() <= 1.0 + 1e-6
    assert used.acceleration_ratio.max() <= 1.0 + 1e-6
    timed = lt.retime(planned.joints, panda.limits, rate=250.0, path_tolerance=1e-4)
    assert lt.check_limits(timed, panda.limits).ok
    begin, end = planned.connected
    assert 0.0 < begin < end < planned.joints.duration
    assert planned.rounds == 2
    assert "obstacle 0" in planned.reasons[0]
    tip, _ = panda.forward_kinematics(planned.joints.positions)
    np.testing.assert_allclose(tip, planned.tip.positions, atol=1e-5)


def test_the_rest_of_the_path_stays_as_learned(skill, box, planned):
    alone = skill.generate(obstacles=[box], dt=0.02)
    times = planned.joints.times
    before = np.flatnonzero(times <= planned.connected[0])
    after = np.flatnonzero(times >= planned.connected[1])
    assert min(len(before), len(after)) > 5
    np.testing.assert_array_equal(planned.tip.positions[before], alone.positions[: len(before)])
    np.testing.assert_array_equal(planned.tip.positions[after], alone.positions[-len(after) :])


def test_events_are_kept(planned):
    assert [event.name for event in planned.joints.events] == ["close"]
    assert [event.name for event in planned.tip.events] == ["close"]


def test_the_answer_has_the_same_bits_each_time(panda, skill, box, planned):
    again = lt.plan_motion(skill, panda, [box], **LAST_RESORT)
    np.testing.assert_array_equal(again.joints.positions, planned.joints.positions)


def test_it_is_not_needed_where_the_tip_can_give_way(panda, skill, box):
    usual = lt.plan_motion(skill, panda, [box], QUERY)
    allowed = lt.plan_motion(skill, panda, [box], QUERY, last_resort="joint_space")
    assert allowed.connected is usual.connected is None
    np.testing.assert_array_equal(allowed.joints.positions, usual.joints.positions)


def test_it_is_off_by_default_and_helps_at_no_end(panda, skill, box, roof):
    with pytest.raises(IkFailure, match="blocked"):
        lt.plan_motion(skill, panda, [box], **ONCE)
    refused("last_resort", lt.plan_motion, skill, panda, last_resort="prayer")
    with pytest.raises(IkFailure, match="no collision-free configuration found at the goal"):
        lt.plan_motion(skill, panda, [roof], QUERY, last_resort="joint_space")


def test_without_ompl_the_extra_is_named(panda, skill, box, monkeypatch):
    def missing(name, *, extra):
        raise MissingDependency("ompl", extra=extra)

    monkeypatch.setattr(connection.optional, "load", missing)
    with pytest.raises(MissingDependency, match=r"leadthrough\[ompl\]"):
        lt.plan_motion(skill, panda, [box], **LAST_RESORT)


def test_a_connection_is_clear_or_not_found_in_the_steps_allowed(panda):
    pytest.importorskip("ompl")
    wall = [lt.Box([0.3, 0.02, 0.6], [0.5, 0.0, 0.3])]
    left, right = (panda.inverse_kinematics([0.5, y, 0.3], DOWN).q for y in (-0.3, 0.3))
    assert not panda.check([left, right], wall).ok
    way = connect_configurations(panda, left, right, wall)
    np.testing.assert_array_equal(way[[0, -1]], [left, right])
    assert panda.check(way, wall).ok
    assert connect_configurations(panda, left, right, wall, steps=1) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"arm": None}, "arm: expected an Arm, got None"),
        ({"start": [0.0] * 6}, "start"),
        ({"goals": [[9.0] * 7]}, "goals: expected joints inside the arm's limits"),
        ({"seed": -1}, "seed"),
        ({"steps": 0}, "steps"),
    ],
)
def test_wrong_arguments_of_a_connection_are_named(panda, change, message):
    q = panda.inverse_kinematics([0.5, 0.0, 0.3], DOWN).q
    refused(message, connect_configurations, **{"arm": panda, "start": q, "goals": q} | change)
