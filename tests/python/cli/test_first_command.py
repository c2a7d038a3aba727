"""`leadthrough info` at a file that nobody has said anything about."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import facts, run

import leadthrough as lt

# An arm of two joints, whose wrist has a tool's frame and two fingers.
BRANCHED = """<robot name="r"><link name="world"/><link name="upper"/><link name="wrist"/>
<link name="left_finger"/><link name="right_finger"/>{tool}
<joint name="turn" type="continuous"><parent link="world"/><child link="upper"/></joint>
<joint name="lift" type="continuous"><parent link="upper"/><child link="wrist"/></joint>
<joint name="left" type="prismatic"><parent link="wrist"/><child link="left_finger"/>
<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
<joint name="right" type="prismatic"><parent link="wrist"/><child link="right_finger"/>
<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint></robot>"""
TOOL = """<link name="tool0"/><joint name="flange" type="fixed"><parent link="wrist"/>
<child link="tool0"/></joint>"""


def test_a_robot_of_several_ends_is_shown_as_a_tree_with_a_proposed_tip(tmp_path):
    path = tmp_path / "arm.urdf"
    for tool, tip in ((TOOL, "tool0"), ("", "wrist")):
        path.write_text(BRANCHED.format(tool=tool))
        told = run("info", path).stdout
        assert "world\n  upper (turn, continuous)\n    wrist (lift, continuous)" in told
        assert f'base = "world"\ntip = "{tip}"' in told
        assert "2 joints" in run("info", path, "--tip", tip).stdout


PALM = """<robot name="p"><link name="a"/><link name="b"/><link name="gripper_link"/>
<link name="moving_jaw"/><joint name="pan" type="continuous"><parent link="a"/><child link="b"/>
</joint><joint name="roll" type="continuous"><parent link="b"/><child link="gripper_link"/></joint>
<joint name="gripper" type="continuous"><parent link="gripper_link"/><child link="moving_jaw"/>
</joint><link name="frame"/><joint name="f" type="fixed"><parent link="gripper_link"/>
<child link="frame"/></joint></robot>"""
TWO_FRAMES = """<link name="ee_link"/><joint name="ee" type="fixed"><parent link="wrist"/>
<child link="ee_link"/></joint>"""


def test_the_proposed_tip_is_the_palm_and_not_a_finger_and_tool0_before_other_frames(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(PALM)
    assert facts("info", path)[0]["tip"] == "gripper_link"
    path.write_text(BRANCHED.format(tool=TWO_FRAMES + TOOL))
    assert facts("info", path)[0]["tip"] == "tool0"


def test_a_robot_without_an_arm_is_shown_as_a_tree(tmp_path):
    path = tmp_path / "table.urdf"
    path.write_text('<robot name="t"><link name="a"/></robot>')
    told = run("info", path).stdout
    assert "no joint moves" in told
    assert "next:" not in told


ZEROS = """<robot name="z"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="j1" type="revolute"><parent link="a"/><child link="b"/>
<limit lower="-1" upper="1" velocity="0" effort="0"/></joint>
<joint name="j2" type="prismatic"><parent link="b"/><child link="c"/>
<limit lower="0" upper="1" velocity="0" effort="9"/></joint>
<joint name="j3" type="revolute"><parent link="c"/><child link="d"/>
<limit velocity="3" effort="9"/></joint></robot>"""


def test_limits_of_zero_are_named_joint_by_joint_and_a_speed_is_assumed_by_name(empty_folder):
    Path("zeros.urdf").write_text(ZEROS)
    told = " ".join(run("info", "zeros.urdf").stdout.split())
    assert "! limits of 0: j1 (velocity, effort), j2 (velocity), j3 (range)." in told
    run("info", "zeros.urdf", "--write-limits", "zeros.toml")
    sources = tomllib.loads(Path("zeros.toml").read_text())["sources"]
    assert sources["velocity"] == "assumed: 1 rad/s (0.1 m/s); the URDF states 0 for j1, j2"
    limits = lt.Arm.from_urdf("zeros.urdf", limits="zeros.toml").limits
    np.testing.assert_allclose(limits.velocity, [1.0, 0.1, 3.0])
    np.testing.assert_allclose(limits.acceleration, [2.0, 0.2, 5.0])


def test_a_path_that_moves_joints_of_zero_speed_names_each_of_them():
    arm = lt.Arm.from_urdf(ZEROS)
    limits = lt.arm.JointLimits(
        arm.joint_names, [-1, 0, 0], [1, 1, 0], [0, 0, 3], [1, 0, 1], [1, 1, 1], [0, 9, 9]
    )
    path = np.linspace([0.0, 0.0, 0.0], [0.5, 0.5, 0.0], 20)
    motion = lt.JointTrajectory(np.linspace(0.0, 1.0, 20), path, joint_names=arm.joint_names)
    named = r"limits of 0 .*: j1 \(velocity\), j2 \(velocity, acceleration\)"
    with pytest.raises(lt.errors.LimitsInfeasible, match=named):
        lt.retime(motion, limits)


def test_recordings_that_cannot_be_read_end_with_code_1(tmp_path):
    (tmp_path / "day.csv").write_text("t,u,v\n0,1,2\n1,2,3\n")
    told = run("info", tmp_path / "day.csv", code=1).stdout
    assert "no names of positions or joints found" in " ".join(told.split())
