"""Obstacles in the way of the elbow: what is solved is clear by another library's measure too."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from arm.coal_arm import CoalArm

import leadthrough as lt
from leadthrough_studies.elbow.scenes import FREE, scene
from leadthrough_studies.elbow.study import MARGIN, STUDY, ElbowConfig
from leadthrough_studies.study import run


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    return run(STUDY, ElbowConfig(scenes=12), out=tmp_path_factory.mktemp("elbow"), jobs=1)


def test_scenes_that_can_be_solved_are(outcome):
    assert not outcome.failures
    for row in outcome.report.table:
        assert row["touch_without"] == row["scenes"] == 12
        assert row["clear"] == row["solved"] >= 2
        assert row["least_distance_m"] >= MARGIN
        assert row["most_tip_error_m"] < 1e-5
    panda = outcome.report.table[0]
    assert panda["solved"] == panda["possible"]


def test_failures_name_the_time_and_what_is_in_the_way(outcome):
    failed = [row for row in outcome.rows if not row["solved"]]
    assert failed
    for row in failed:
        assert " s: " in row["failure"]
        assert "blocked" in row["failure"] or "jump" in row["failure"]


@pytest.mark.parametrize("name", ["panda", "ur3"])
def test_coal_finds_no_touch(outcome, name):
    row = next(row for row in outcome.rows if row["arm"] == name and row["solved"])
    arm = lt.Arm.load(name)
    made = scene(arm, name, np.random.default_rng([0, row["index"]]))
    joints = arm.follow(
        made.tip, seed=made.joints.positions[0], free=FREE[name], obstacles=made.obstacles
    )
    peer = CoalArm(name)
    for q in joints.positions:
        peer.place(q)
        for shape in made.obstacles:
            pose = pin.SE3(np.eye(3), shape.position)
            assert peer.distance_to(peer.moving_links(), _in_coal(shape), pose) > MARGIN - 1e-5


def _in_coal(shape):
    if isinstance(shape, lt.Box):
        return coal.Box(*shape.size)
    if isinstance(shape, lt.Sphere):
        return coal.Sphere(shape.radius)
    return coal.Cylinder(shape.radius, shape.length)
