"""Robot descriptions from anywhere: vast, absurd or curious ones are refused, not in minutes."""

import numpy as np
import pytest
from urdfs import CUBE, one_joint, with_mesh

import leadthrough as lt
from leadthrough.errors import InvalidInput, InvalidRobot


def robot(inside="", link="", velocity="1"):
    limit = f'<limit lower="-1" upper="1" velocity="{velocity}" effort="1e308"/>'
    return one_joint(inside + limit, kind="revolute", link=link)


def refused(document, message):
    with pytest.raises(InvalidRobot, match=message):
        lt.Arm.from_urdf(document)


def test_an_element_of_a_million_attributes_is_refused():
    many = "".join(f' a{i}="1"' for i in range(1_000_000))
    refused(f'<robot name="r"{many}><link name="a"/></robot>', "more than 64 attributes")


def test_many_capsules_are_read_as_fast_as_other_elements():
    shapes = '<collision><geometry><capsule radius="1" length="1"/></geometry></collision>' * 60_000
    assert lt.Arm.from_urdf(robot(link=shapes)).robot.collisions == {"b": 60_000}


def test_entities_are_not_expanded():
    laughs = "".join(f'<!ENTITY l{i} "{10 * f"&l{i - 1};"}">' for i in range(1, 12))
    head = f'<!DOCTYPE robot [<!ENTITY l0 "ha">{laughs}]>'
    refused(head + robot().replace('"one"', '"&l11;"'), "unsupported markup")
    refused('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>' + robot(), "unsupported")


@pytest.mark.parametrize(
    ("inside", "link", "named"),
    [
        ('<origin xyz="1e308 0 0"/>', "", "joint 'j': origin xyz"),
        ('<origin rpy="0 1e308 0"/>', "", "joint 'j': origin rpy"),
        ('<mimic joint="j" multiplier="1e300"/>', "", "joint 'j'"),
        ("", '<inertial><mass value="1e308"/></inertial>', "link 'b': mass value"),
        ("", '<inertial><origin xyz="0 0 -1e12"/><mass value="1"/></inertial>', "link 'b': origin"),
        ("", '<collision><geometry><sphere radius="1e308"/></geometry></collision>', "link 'b'"),
        ("", '<collision><geometry><box size="1 1e200 1"/></geometry></collision>', "link 'b'"),
    ],
)
def test_sizes_that_no_robot_has_are_refused(inside, link, named):
    refused(robot(inside, link), named)


def test_what_is_accepted_stays_finite():
    arm = lt.Arm.from_urdf(robot('<origin xyz="1e9 -1e9 1e9" rpy="1e9 0 0"/>', velocity="1e308"))
    position, orientation = arm.forward_kinematics([0.5])
    assert np.isfinite(position).all()
    assert np.linalg.norm(orientation) == pytest.approx(1.0)
    assert np.isfinite(arm.jacobian([0.5])).all()
    assert arm.limits.velocity[0] == 1e308


def test_a_mesh_outside_is_named_with_what_to_do(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    document = with_mesh(tmp_path / "cube.obj")
    arm = lt.Arm.from_urdf(document)
    with pytest.raises(InvalidRobot, match="name its folder in mesh_folders"):
        arm.check([[0.0]])
    arm = lt.Arm.from_urdf(document, mesh_folders=[tmp_path])
    assert arm.check([[0.0]]).ok


@pytest.mark.parametrize("path", ["a\0b.toml", "\ud800.toml", "/dev/zero", "."])
def test_limits_that_no_file_can_be_are_refused(path):
    with pytest.raises(InvalidInput, match="limits"):
        lt.Arm.from_urdf(robot(), limits=path)


def test_limits_that_nest_deep_are_refused(tmp_path):
    (tmp_path / "deep.toml").write_text("a = " + "[" * 100_000)
    with pytest.raises(InvalidInput, match="not a TOML document"):
        lt.Arm.from_urdf(robot(), limits=tmp_path / "deep.toml")


@pytest.mark.parametrize("folder", ["a\0b", "\ud800"])
def test_folders_of_meshes_that_cannot_be_are_refused(folder):
    with pytest.raises(InvalidInput, match="mesh_folders"):
        lt.Arm.from_urdf(robot(), mesh_folders=[folder])
