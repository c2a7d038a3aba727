"""All links' poses, against the kinematics of an arm that ends in each of them."""

import numpy as np
import pytest
from motions import configurations

import leadthrough as lt
from leadthrough.arm.link_poses import link_poses
from leadthrough.errors import InvalidInput, InvalidRobot

MIMICRY = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="side"/>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<origin xyz="0.1 0 0" rpy="0 0.5 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="finger" type="prismatic"><parent link="c"/><child link="side"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/>
<mimic joint="turn" multiplier="0.5" offset="0.25"/></joint></robot>"""


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_links_are_where_kinematics_put_them(name):
    arm = lt.Arm.load(name)
    q = configurations(arm, 20, 0)
    poses = link_poses(arm, q)
    compared = 0
    for link, (turned, position) in poses.items():
        try:
            shorter = lt.Arm.from_urdf(arm.document, base=arm.base, tip=link)
        except (InvalidRobot, InvalidInput):  # no joint in between, or a joint outside the arm
            continue
        own = [arm.joint_names.index(joint) for joint in shorter.joint_names]
        x, orientation = shorter.forward_kinematics(q[:, own])
        assert np.allclose(position, x, atol=1e-12)
        assert np.allclose(turned, lt.rotations.to_matrix(orientation), atol=1e-12)
        compared += 1
    assert compared >= 6


def test_base_link_stays_at_the_origin_of_its_own_frame():
    arm = lt.Arm.from_urdf(MIMICRY, base="b", tip="c")
    turned, position = link_poses(arm, configurations(arm, 5, 0))["b"]
    assert np.allclose(position, 0.0)
    assert np.allclose(turned, np.eye(3))


def test_joint_that_mimics_moves_its_link():
    arm = lt.Arm.from_urdf(MIMICRY, tip="c")
    poses = link_poses(arm, np.array([[0.3, 0.0], [0.3, 1.0]]))
    (turned, at), (_, finger) = poses["c"], poses["side"]
    local = np.einsum("nji,nj->ni", turned, finger - at)
    assert np.allclose(local, [[0.0, 0.25, 0.0], [0.0, 0.75, 0.0]])


def test_locked_joint_stays_at_its_value():
    arm = lt.Arm.from_urdf(MIMICRY, tip="c", locked_joints={"slide": 0.4})
    _, position = link_poses(arm, np.zeros((1, 1)))["b"]
    assert np.allclose(position, [[0.1 + 0.4 * np.sin(0.5), 0.0, 0.4 * np.cos(0.5)]])
