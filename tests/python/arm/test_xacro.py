"""Xacro files are expanded by its own library, and what is left of xacro in a URDF is refused."""

import sys

import pytest
import xacro
from urdfs import one_joint

import leadthrough as lt
from leadthrough.errors import InvalidRobot, MissingDependency

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
PLAIN = one_joint()
WITH_TOOL = PLAIN.replace("<robot", f"<robot {NAMESPACE}").replace(
    "</robot>",
    '<xacro:macro name="tool" params="length"><link name="tool"/><joint name="flange" type="fixed">'
    '<parent link="b"/><child link="tool"/><origin xyz="0 0 ${length}"/></joint></xacro:macro>'
    '<xacro:tool length="${0.1 + 0.2}"/></robot>',
)


@pytest.mark.parametrize(
    "element",
    [
        '<xacro:tool length="1"/>',
        '<xacro:if value="1"><link name="c"/></xacro:if>',
        '<xacro:include filename="$(find arm)/tool.xacro"/>',
        '<x:tool xmlns:x="http://ros.org/wiki/xacro"/>',
    ],
)
def test_an_element_of_xacro_in_a_urdf_is_refused_with_the_cure(element, tmp_path):
    document = PLAIN.replace("</robot>", f"{element}</robot>")
    with pytest.raises(InvalidRobot, match=r"of xacro, not of URDF; expand the file"):
        lt.Arm.from_urdf(document)
    (tmp_path / "arm.urdf").write_text(document)
    with pytest.raises(InvalidRobot, match=r"xacro robot.urdf.xacro > robot.urdf"):
        lt.Arm.from_urdf(tmp_path / "arm.urdf")


def test_a_namespace_or_comment_that_expanding_leaves_is_none():
    left = PLAIN.replace("<robot", f"<robot {NAMESPACE}").replace(
        "</robot>", '<!-- <xacro:tool length="1"/> --></robot>'
    )
    assert lt.Arm.from_urdf(left).joint_names == ("j",)


def test_a_xacro_file_is_expanded_as_by_its_library(tmp_path):
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(WITH_TOOL)
    arm = lt.Arm.from_urdf(path)
    expected = lt.Arm.from_urdf(xacro.process_file(str(path)).toxml())
    assert arm.tip == expected.tip == "tool"
    position, _ = arm.forward_kinematics([0.3])
    assert position[2] == pytest.approx(0.3)


def test_a_xacro_file_that_cannot_be_expanded_says_why(tmp_path):
    path = tmp_path / "arm.xacro"
    path.write_text(WITH_TOOL.replace("0.1 + 0.2", "unknown"))
    with pytest.raises(InvalidRobot, match=r"arm.xacro: cannot be expanded .*unknown"):
        lt.Arm.from_urdf(path)


def test_without_the_library_a_xacro_file_names_the_extra(tmp_path, monkeypatch):
    path = tmp_path / "arm.xacro"
    path.write_text(WITH_TOOL)
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(MissingDependency, match=r"leadthrough\[xacro\]"):
        lt.Arm.from_urdf(path)
