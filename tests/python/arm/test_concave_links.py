"""Links whose meshes are concave, against coal's distances of the meshes themselves."""

import numpy as np
import pytest
from foreign_arms import urdf_in_package
from motions import configurations

import leadthrough as lt
from leadthrough_studies.coal_arm import CoalArm

STANDS_OUT = 0.007  # m, at most, of the parts from the meshes of a UR5


@pytest.fixture(scope="module")
def ur5():
    urdf = urdf_in_package("example-robot-data", "ur5_robot.urdf").resolve()
    arm = lt.Arm.from_urdf(urdf, tip="tool0")
    return arm, CoalArm(arm, [str(urdf.parents[4])])


def test_links_that_are_apart_are_clear_although_their_hulls_overlap(ur5):
    arm, peer = ur5
    rows = configurations(arm, 100, 5)
    for q, ours in zip(rows, arm.self_distance(rows), strict=True):
        peer.place(q)
        theirs = min(peer.link_distance(*pair) for pair in arm.collision_pairs.checked)
        assert ours < max(theirs, 0.0) + 1e-6
        assert ours > 0.0 or theirs < STANDS_OUT


def test_an_obstacle_is_no_farther_than_from_the_meshes(ur5):
    arm, peer = ur5
    rows = configurations(arm, 100, 6)
    middles = np.random.default_rng(6).uniform(-0.9, 0.9, (100, 3))
    for q, middle in zip(rows, middles, strict=True):
        ball = lt.Sphere(0.1, middle)  # too large to be inside
        peer.place(q)
        theirs = peer.distance_to(peer.moving_links(), *peer.solid(ball))
        ours = max(arm.distance(q, [ball]), 0.0)
        assert theirs - STANDS_OUT < ours < max(theirs, 0.0) + 1e-6


def test_links_that_are_nested_by_design_stay_left_out():
    urdf = urdf_in_package("example-robot-data", "pr2.urdf")
    arm = lt.Arm.from_urdf(urdf, base="torso_lift_link", tip="l_wrist_roll_link")
    assert arm.collision_pairs.left_out["l_shoulder_pan_link", "l_upper_arm_link"] == "always"
