"""Through joint space where no path of the tip leaves the arm room, by OMPL's RRT-Connect."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput, MissingDependency
from leadthrough.motion_planning import connect_configurations, connection

DOWN = np.array([0.0, 1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def shown():
    """A reach across the table, the tool pointing down, with the gripper closed on the way."""
    u = np.linspace(0.0, 1.0, 61)
    rise, bow = lt.trajectories.minimum_jerk_time_scaling(u), np.sin(np.pi * u)
    way = np.column_stack([0.45 + 0.05 * bow, 0.6 * rise - 0.3, 0.25 + 0.1 * bow])
    closed = lt.Event(1.0, "close")
    return lt.PoseTrajectory(2.0 * u, way, np.tile(DOWN, (61, 1)), [closed])


@pytest.fixture(scope="module")
def box():
    """On the way of the hand."""
    return lt.Box([0.08, 0.06, 0.1], [0.42, 0.0, 0.44])


@pytest.fixture(scope="module")
def planned(panda, shown, box):
    pytest.importorskip("ompl")
    skill = lt.DMP().fit([shown])
    return lt.plan_motion(
        skill, panda, [box], lt.Query(dt=0.02), rounds=1, last_resort="joint_space"
    )


def test_the_dead_part_is_connected_and_certified(panda, shown, box, planned):
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


def test_the_rest_of_the_path_stays_as_learned(panda, shown, box, planned):
    alone = lt.DMP().fit([shown]).generate(obstacles=[box], dt=0.02)
    times = planned.joints.times
    before = np.flatnonzero(times <= planned.connected[0])
    after = np.flatnonzero(times >= planned.connected[1])
    assert min(len(before), len(after)) > 5
    np.testing.assert_array_equal(planned.tip.positions[before], alone.positions[: len(before)])
    np.testing.assert_array_equal(planned.tip.positions[after], alone.positions[-len(after) :])


def test_events_are_kept(planned):
    assert [event.name for event in planned.joints.events] == ["close"]
    assert [event.name for event in planned.tip.events] == ["close"]


def test_the_answer_has_the_same_bits_each_time(panda, shown, box, planned):
    skill = lt.DMP().fit([shown])
    again = lt.plan_motion(
        skill, panda, [box], lt.Query(dt=0.02), rounds=1, last_resort="joint_space"
    )
    np.testing.assert_array_equal(again.joints.positions, planned.joints.positions)


def test_it_is_not_needed_where_the_tip_can_give_way(panda, shown, box):
    skill = lt.DMP().fit([shown])
    usual = lt.plan_motion(skill, panda, [box], lt.Query(dt=0.02))
    allowed = lt.plan_motion(skill, panda, [box], lt.Query(dt=0.02), last_resort="joint_space")
    assert allowed.connected is usual.connected is None
    np.testing.assert_array_equal(allowed.joints.positions, usual.joints.positions)


def test_it_is_off_by_default_and_helps_at_no_end(panda, shown, box):
    skill = lt.DMP().fit([shown])
    with pytest.raises(IkFailure, match="blocked"):
        lt.plan_motion(skill, panda, [box], lt.Query(dt=0.02), rounds=1)
    with pytest.raises(InvalidInput, match="last_resort"):
        lt.plan_motion(skill, panda, last_resort="prayer")
    roof = lt.Box([0.3, 0.1, 0.1], [0.45, 0.3, 0.4])  # where the hand is at the goal
    with pytest.raises(IkFailure, match="no collision-free configuration found at the goal"):
        lt.plan_motion(skill, panda, [roof], lt.Query(dt=0.02), last_resort="joint_space")


def test_without_ompl_the_extra_is_named(panda, shown, box, monkeypatch):
    def missing(name, *, extra):
        raise MissingDependency("ompl", extra=extra)

    monkeypatch.setattr(connection.optional, "load", missing)
    skill = lt.DMP().fit([shown])
    with pytest.raises(MissingDependency, match=r"leadthrough\[ompl\]"):
        lt.plan_motion(skill, panda, [box], lt.Query(dt=0.02), rounds=1, last_resort="joint_space")


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
    with pytest.raises(InvalidInput, match=message):
        connect_configurations(**{"arm": panda, "start": q, "goals": q} | change)
